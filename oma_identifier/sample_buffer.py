"""Measurements in, uniform windows out, on header stamps alone.

Sources (sensors and recorders) are put in order one by one (`source_stream.py`), placed on one
common grid by band-limited interpolation (`lattice.py`, `resample.py`), stretch by stretch, each
sample once; windows are cut from the stretches.  Where windows begin and end depends on the
stamps only, so a replay gives the same windows as the file it came from.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
import math

import numpy as np

from modal_core.channel import Channel, SensorLayout
from modal_core.measurements import (
    JointSamples,
    Measurement,
    NANOSECONDS_PER_SECOND,
    SampleBlock,
    StampedSamples,
)
from modal_core.window import Window
from oma_identifier.joint_track import JointTrack
from oma_identifier.one_thread import one_thread
from oma_identifier.segment import Segment
from oma_identifier.settings import IdentificationSettings
from oma_identifier.source import make_source, Source
from oma_identifier.window_cut import cut_window

START_NS = NANOSECONDS_PER_SECOND
EXPECT_NS = 5 * NANOSECONDS_PER_SECOND
"""Sources that begin within this time begin together."""
MOST_SOURCES = 256
SHORTEST_PARTIAL = 0.1
"""Share of a window that is worth a partial window at a break or at the end."""
MOST_PENDING = 4_000_000
"""Samples of one source that may wait before the oldest are given up."""


@dataclass
class BufferCounters:
    """What happened since the start.

    Parameters
    ----------
    n_segments : int
        Stretches of data without interruption.
    n_rejected : int
        Measurements of no known channel, malformed, or from too many sources.
    reasons : dict of str to int
        Why a new segment was begun, and why measurements were rejected.
    """

    n_segments: int = 0
    n_rejected: int = 0
    reasons: dict[str, int] = field(default_factory=dict)

    def note(self, reason: str) -> None:
        """Count one occurrence."""
        self.reasons[reason] = self.reasons.get(reason, 0) + 1


class SampleBuffer:
    """Collects measurements and cuts them into windows.

    Parameters
    ----------
    settings : IdentificationSettings
        Length of a window and of a hop.
    layout : SensorLayout or None
        The channels to expect; None: whatever arrives.

    Attributes
    ----------
    n_windows : int
        Windows cut so far; the index of the next.
    """

    def __init__(
        self, settings: IdentificationSettings, layout: SensorLayout | None = None
    ) -> None:
        self.settings = settings
        self.layout = layout
        self.counters = BufferCounters()
        self.joints = JointTrack(2.0 * settings.window_s + 10.0)
        self._sources: dict[str, Source] = {}
        self._seen: dict[str, Channel] = {}
        self._expected: set[str] = set()
        self._ignored: set[str] = set()
        self._segment: Segment | None = None
        self._ready: list[Window] = []
        self.n_windows = 0
        self._flags: tuple[str, ...] = ()

    @property
    def channels(self) -> tuple[Channel, ...]:
        """All channels that are expected or have been seen."""
        expected = self.layout.channels if self.layout else ()
        return (
            *expected,
            *(channel for channel in self._seen.values() if channel not in expected),
        )

    def expect(self, source: str) -> None:
        """Wait a little for a source that is known to exist before the first window begins."""
        self._expected.add(source)

    def add(self, measurement: Measurement) -> None:
        """Take in samples or joint states, in order of arrival."""
        if isinstance(measurement, JointSamples):
            self.joints.add(measurement)
            return
        source = self._source_of(measurement)
        if source is None:
            return
        if isinstance(measurement, SampleBlock):
            source.add_block(measurement)
        else:
            source.add_stamped(measurement)
        if source.stream.n_pending > MOST_PENDING:
            self._break('overload')
        segment = self._segment
        early = segment is not None and source.stream.newest_ns < segment.due_ns
        if not early or source.stream.jumped:
            self._work(closing=False)

    def windows(self) -> Iterator[Window]:
        """Yield the windows that are complete."""
        while self._ready:
            yield self._ready.pop(0)

    def finish(self) -> Iterator[Window]:
        """Yield what is left: complete windows, then a partial one."""
        self._work(closing=True)
        self._close_segment()
        self._sources.clear()
        self._ignored.clear()
        yield from self.windows()

    def _source_of(self, measurement: StampedSamples | SampleBlock) -> Source | None:
        key = measurement.source
        if isinstance(measurement, SampleBlock):
            # Several recorders may share a topic; their channels tell them apart.
            key = f'{key} {" ".join(measurement.channel_names)}'
        source = self._sources.get(key)
        if source is not None or key in self._ignored:
            return source
        source = make_source(measurement, self.layout)
        names = {channel.name for known in self._sources.values() for channel in known.channels}
        if source is not None and names & {channel.name for channel in source.channels}:
            self.counters.note('channel_sent_twice')
            source = None
        if source is None or len(self._sources) >= MOST_SOURCES:
            self.counters.n_rejected += 1
            self.counters.note('not_in_layout' if source is None else 'too_many_sources')
            if len(self._ignored) < MOST_SOURCES:
                self._ignored.add(key)
            return None
        source.name = key
        self._seen.update({channel.name: channel for channel in source.channels})
        self._sources[key] = source
        return source

    def _work(self, *, closing: bool) -> None:
        while True:
            if any(source.stream.jumped for source in self._sources.values()):
                self._handle_jump(closing=closing)
            if self._segment is None and not self._begin(closing=closing):
                return
            if not self._advance(closing=closing):
                return

    def _begin(self, *, closing: bool) -> bool:
        """Begin a segment when a second of data is there."""
        begun = [
            source
            for source in self._sources.values()
            if source.stream.n_pending and not source.stream.jumped
        ]
        spans = {source.name: _span(source) for source in begun}
        if not begun:
            return False
        first = min(start for start, _ in spans.values())
        held_ns = max(end for _, end in spans.values()) - first
        silent = self._expected - {name.split()[0] for name in spans}
        if not closing and held_ns < (EXPECT_NS if silent else START_NS):
            return False
        together = [source for source in begun if spans[source.name][0] - first <= START_NS]
        for source in begun:
            source.learn_period()
        timed = [source for source in together if source.period_ns > 0.0]
        if not timed:
            return False
        reference = min(timed, key=_preference)
        start_ns = max(spans[source.name][0] for source in timed)
        self._segment = self._new_segment(reference, start_ns)
        self.counters.n_segments += 1
        return True

    def _new_segment(self, reference: Source, start_ns: int) -> Segment:
        rate = reference.rate_hz
        if reference.clock is None:
            rate = round(rate, 2)
        else:
            stamps = reference.stream.samples().stamp_ns
            start_ns = int(stamps[min(int(np.searchsorted(stamps, start_ns)), len(stamps) - 1)])
        return Segment(
            start_ns=start_ns,
            sample_rate_hz=rate,
            reference=reference,
            window_rows=max(2, round(self.settings.window_s * rate)),
            hop_rows=max(1, round(self.settings.hop * rate)),
        )

    def _active(self) -> list[Source]:
        return [
            source
            for source in self._sources.values()
            if source.period_ns > 0.0 and not source.stream.jumped
        ]

    def _advance(self, *, closing: bool) -> bool:
        """Make the next stretch of rows; False when its samples are not there yet."""
        segment = self._segment
        if segment is None:
            return False
        for source in self._sources.values():
            if source.period_ns == 0.0:
                source.learn_period()
        sources = self._active()
        if not sources:
            return False
        end = segment.next_end
        if not segment.ready(sources, closing=closing):
            end = segment.n_rows + segment.rows_left(sources) if closing else segment.n_rows
            if end <= segment.n_rows:
                return False
        silent = segment.advance(sources, end)
        if silent.any():
            self._split(end - len(silent), silent)
            return True
        self._cut_windows()
        return self._check_rates()

    def _split(self, first_row: int, silent: np.ndarray) -> None:
        """End the segment where every source falls silent."""
        segment = self._segment
        if segment is None:
            return
        segment.n_rows = first_row + int(np.argmax(silent))
        resume = first_row + len(silent) - int(np.argmin(silent[::-1]))
        self._cut_windows()
        resume_ns = segment.time_ns(resume if not silent[-1] else first_row + len(silent))
        self._close_segment()
        for source in self._sources.values():
            source.stream.forget(resume_ns - round(source.period_ns / 2))
        self._break('gap')

    def _check_rates(self) -> bool:
        segment = self._segment
        if segment is not None and segment.reference.rate_changed:
            segment.reference.rate_changed = False
            self._close_segment()
            self._break('rate_change')
        return True

    def _cut_windows(self) -> None:
        segment = self._segment
        if segment is None:
            return
        while segment.next_window * segment.hop_rows + segment.window_rows <= segment.n_rows:
            first = segment.next_window * segment.hop_rows
            self._cut(first, first + segment.window_rows, partial=False)
            segment.next_window += 1
            segment.forget()

    def _close_segment(self) -> None:
        """Cut what is left of a segment as a partial window, and end the segment."""
        segment, self._segment = self._segment, None
        if segment is None:
            return
        first = segment.next_window * segment.hop_rows
        covered = 0
        if segment.next_window:
            covered = first - segment.hop_rows + segment.window_rows
        least = max(2, math.ceil(SHORTEST_PARTIAL * segment.window_rows))
        is_new = segment.n_rows - covered > segment.sample_rate_hz
        if segment.n_rows - first >= least and (is_new or not segment.next_window):
            self._segment = segment
            self._cut(first, segment.n_rows, partial=True)
            self._segment = None

    def _cut(self, first: int, last: int, *, partial: bool) -> None:
        segment = self._segment
        if segment is None:
            return
        flags = (*self._flags, 'partial') if partial else self._flags
        with one_thread():
            window = cut_window(
                index=self.n_windows,
                segment=segment,
                sources=list(self._sources.values()),
                rows=range(first, last),
                layout=self.layout,
                joints=self.joints,
                flags=flags,
            )
        self.n_windows += 1
        self._flags = ()
        self._ready.append(window)

    def _break(self, reason: str) -> None:
        """Note why the next segment begins."""
        self._segment = None
        self.counters.note(reason)
        self._flags = tuple(dict.fromkeys((*self._flags, reason)))

    def _handle_jump(self, *, closing: bool) -> None:
        """Begin anew when the clocks of most sources jumped back; else restart the odd one."""
        live = list(self._sources.values())
        jumped = [source for source in live if source.stream.jumped]
        waited = max(
            int(source.stream.jumped[-1].stamp_ns[-1] - source.stream.jumped[0].stamp_ns[0])
            for source in jumped
        )
        if len(jumped) < len(live) and waited < START_NS and not closing:
            return
        if 2 * len(jumped) >= len(live):
            self._close_segment()
            self._break('clock_jump')
            self.joints.clear()
            for source in live:
                source.restart()
            return
        for source in jumped:
            source.flags.add('clock_jump')
            source.restart()


def _span(source: Source) -> tuple[int, int]:
    stamps = source.stream.samples().stamp_ns
    return int(stamps[0]), int(stamps[-1])


def _preference(source: Source) -> tuple[float, bool, str]:
    """Prefer the fastest source as reference, of equals one that counts, then by name."""
    return (round(source.period_ns, 0), source.clock is None, source.name)
