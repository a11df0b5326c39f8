"""Sensors that change within a record: left out while they do, and told apart from then on.

Shapes of before and after such a change are of different sensors.  The channels say since when
they are what they are, so that nothing is averaged over the change.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modal_core.samples import Samples
from modal_core.window import Pose
from oma_identifier.motion import Cleaned
from oma_identifier.synchrony.change_kind import SHAPE
from oma_identifier.synchrony.changed_sensors import Change, find_change
from oma_identifier.synchrony.clock_drift import DRIFTS
from oma_identifier.synchrony.coherence import INCOHERENT, variance
from oma_identifier.synchrony.in_step import columns_of, in_step
from oma_identifier.synchrony.peak_course import Course, course_of
from oma_identifier.synchrony.sensor_peaks import Peak
from oma_identifier.synchrony.thresholds import SYNCHRONY

MOMENTS = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95)
"""Shares of a window at which changes are looked for; at its start, since the last window."""


class SensorChanges:
    """Looks for changes of sensors in window after window, and keeps those found."""

    def __init__(self) -> None:
        self._changes: dict[str, Change] = {}
        self._unclear: Change | None = None
        self._drifting: set[str] = set()
        self._names: tuple[str, ...] = ()
        self._courses: list[Course] = []
        self._pose: NDArray[np.float64] | None = None
        self._start_ns = self._begin_ns = 0

    def mark(
        self, samples: Samples, peaks: Sequence[Peak], cleaned: Cleaned, pose: Pose | None
    ) -> Cleaned:
        """Return a window without the sensors that change in it; the very same one where none do.

        Parameters
        ----------
        samples : Samples
            Of all sensors.
        peaks : sequence of Peak
            Of these samples; none where they were not looked at.
        cleaned : Cleaned
            What is left of the window.
        pose : Pose or None
            Where the robot is.
        """
        if samples.start_ns < self._start_ns:
            self._forget(samples.start_ns)
        self._start_ns = samples.start_ns
        if 'gross_motion' in cleaned.flags or not self._is_in_place(pose):
            self._courses = []
        if peaks and 'gross_motion' not in cleaned.flags:
            self._look(samples, peaks)
        is_odd = self._changes or self._unclear or self._drifting
        return self._marked(samples, cleaned) if is_odd else cleaned

    def _forget(self, from_ns: int) -> None:
        """Forget what was found at times that come again: the clock was set back."""
        self._changes = {s: c for s, c in self._changes.items() if c.to_ns <= from_ns}
        self._courses, self._begin_ns, self._unclear = [], 0, None
        self._drifting = set()

    def _is_in_place(self, pose: Pose | None) -> bool:
        before, self._pose = self._pose, None if pose is None else pose.position
        if before is None or self._pose is None or len(before) != len(self._pose):
            return before is None and self._pose is None
        return bool(np.abs(self._pose - before).max(initial=0.0) < SYNCHRONY.same_pose_rad)

    def _look(self, samples: Samples, peaks: Sequence[Peak]) -> None:
        scale = np.sqrt(variance(samples.acceleration))
        courses = [course_of(peak, samples, scale) for peak in peaks]
        earlier = self._earlier(samples.channel_names)
        joined = [course.after(earlier).since(self._begin_ns) for course in courses]
        length_ns = samples.end_ns - samples.start_ns
        moments = samples.start_ns + np.rint(np.array(MOMENTS) * length_ns).astype(np.int64)
        change = find_change(joined, columns_of(samples.channels), moments)
        self._unclear = change if change is not None and change.kind == SHAPE else None
        if change is not None and change.kind == DRIFTS:
            self._drifting |= set(change.sensors)
        elif change is not None and change.kind != SHAPE:
            self._begin_ns = change.to_ns
            joined = [course.since(change.to_ns) for course in joined]
            self._changes |= {name: self._new(name, change) for name in change.sensors}
        if not set(samples.channel_names) < set(self._names):
            # Sensors that are missing in a window may come back changed.
            self._names, self._courses = samples.channel_names, joined

    def _earlier(self, names: tuple[str, ...]) -> list[Course]:
        """Return what earlier windows showed of these channels."""
        if not set(names) <= set(self._names):
            return []
        columns = [self._names.index(name) for name in names]
        return [course.of_channels(columns) for course in self._courses]

    def _new(self, name: str, change: Change) -> Change:
        """Return a change of a sensor; one that the window saw already goes on in it."""
        last = self._changes.get(name)
        if last is None or last.to_ns <= self._start_ns:
            return change
        return replace(change, from_ns=min(last.from_ns, change.from_ns))

    def _unclear_flags(self, samples: Samples) -> dict[str, str]:
        """Return the flags of channels that broke in a window, by a sensor or by the structure."""
        unclear = self._unclear
        if unclear is None or unclear.to_ns <= samples.start_ns:
            return {}
        names = [c.name for c in samples.channels if c.sensor in unclear.sensors]
        return dict.fromkeys(names, SHAPE)

    def _marked(self, samples: Samples, cleaned: Cleaned) -> Cleaned:
        found = cleaned.channel_flags
        if self._drifting:
            # It is known why sensors have nothing in common.
            found = {name: flag for name, flag in found.items() if flag != INCOHERENT}
        flags = self._unclear_flags(samples)
        since_ns: dict[str, int] = {}
        out: set[str] = set()
        for channel in samples.channels:
            if channel.sensor in self._drifting:
                flags[channel.name] = DRIFTS
                out.add(channel.name)
            change = self._changes.get(channel.sensor)
            if change is not None and change.from_ns < samples.end_ns:
                flags[channel.name], since_ns[channel.name] = change.kind, change.to_ns
                if change.is_sure and change.to_ns > samples.start_ns:
                    out.add(channel.name)
        channels = cleaned.samples.channels
        kept = np.array([channel.name not in out for channel in channels])
        if not kept.all():
            cleaned = in_step(cleaned, np.zeros(len(kept)), kept)
        channels = tuple(
            replace(channel, since_ns=since_ns.get(channel.name, 0))
            for channel in cleaned.samples.channels
        )
        return replace(
            cleaned,
            samples=replace(cleaned.samples, channels=channels),
            channel_flags={**found, **flags},
            since_ns=since_ns,
            left_out=tuple(dict.fromkeys((*cleaned.left_out, *out))),
        )
