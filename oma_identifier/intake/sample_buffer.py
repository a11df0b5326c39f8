"""Measurements in, uniform windows out, on header stamps alone.

Sources (sensors and recorders) are put in order one by one (`source_stream.py`), placed on one
common grid by band-limited interpolation (`lattice.py`, `resample.py`), stretch by stretch, each
sample once; windows are cut from the stretches.  Where windows begin and end depends on the
stamps only, so a replay gives the same windows as the file it came from.
"""

from collections import Counter
from collections.abc import Iterator, Sequence

import numpy as np

from modal_core.channel import Channel, SensorLayout
from modal_core.measurements import (
    JointSamples,
    Measurement,
    NANOSECONDS_PER_SECOND,
    SampleBlock,
)
from modal_core.window import Window
from oma_identifier.intake.buffer_counters import BufferCounters
from oma_identifier.intake.joint_track import JointTrack
from oma_identifier.intake.leading_clock import APART, LeadingClock
from oma_identifier.intake.rate_limits import RateCheck
from oma_identifier.intake.segment import Segment
from oma_identifier.intake.source import Source
from oma_identifier.intake.source_roster import SourceRoster
from oma_identifier.intake.thresholds import INTAKE
from oma_identifier.intake.window_cutter import WindowCutter
from oma_identifier.settings import IdentificationSettings


class SampleBuffer:
    """Collects measurements and cuts them into windows.

    Parameters
    ----------
    settings : IdentificationSettings
        Length of a window and of a hop.
    layout : SensorLayout or None
        The channels to expect; None: whatever arrives.
    """

    def __init__(
        self, settings: IdentificationSettings, layout: SensorLayout | None = None
    ) -> None:
        self.settings = settings
        self.layout = layout
        self.counters = BufferCounters()
        self._joints_aside: Counter[str] = Counter()
        self.joints = JointTrack(2.0 * settings.window_s + 10.0, self._joints_aside)
        self._clock = LeadingClock()
        self._rates = RateCheck(settings.window_s, self.counters)
        self._roster = SourceRoster(layout, self.counters, gyroscopes=settings.gyroscopes)
        self._expected: set[str] = set()
        self._idle: set[str] = set()
        self._segment: Segment | None = None
        self._cutter = WindowCutter(layout, self.joints)

    @property
    def n_windows(self) -> int:
        """Windows cut so far; the index of the next."""
        return self._cutter.n_windows

    @n_windows.setter
    def n_windows(self, n_windows: int) -> None:
        self._cutter.n_windows = n_windows

    @property
    def channels(self) -> tuple[Channel, ...]:
        """All channels that are expected or have been seen."""
        expected = self.layout.channels if self.layout else ()
        # A copy: whoever asks from another thread must not meet a change half-way.
        seen = list(self._roster.seen.values())
        return tuple({channel.name: channel for channel in (*expected, *seen)}.values())

    @property
    def now_ns(self) -> int | None:
        """Time of the newest samples [ns]; None before the first."""
        return self._clock.now_ns

    @property
    def n_held(self) -> int:
        """Samples of all sources that are held now: those that wait, and those in their place."""
        placed = self._segment.rows.values() if self._segment else ()
        waiting = sum(source.stream.n_pending for source in self._roster.sources.values())
        return waiting + sum(rows.n_held for rows in placed)

    def expect(self, source: str) -> None:
        """Wait a little for a source that is known to exist before the first window begins."""
        self._expected.add(source)

    def add(self, measurement: Measurement) -> None:
        """Take in samples or joint states, in order of arrival."""
        if isinstance(measurement, JointSamples):
            self.joints.add(measurement, self._clock.now_ns)
            return
        source = self._roster.source_of(measurement)
        if source is None:
            return
        if isinstance(measurement, SampleBlock):
            source.add_block(measurement)
        else:
            source.add_stamped(measurement)
        self._note(source, len(measurement.acceleration))
        segment = self._segment
        early = segment is not None and source.stream.newest_ns < segment.due_ns
        if not early or source.stream.jumped:
            self._work(closing=False)

    def _note(self, source: Source, n_samples: int) -> None:
        """Follow whose time leads, and count what was set aside."""
        if source.stream.n_bytes > INTAKE.most_pending_bytes:
            source.stream.drop()
            self._break('overload')
        if source.set_aside:
            self.counters.collect(source.set_aside)
        if self._clock.note(source, n_samples):
            self._look()

    def _look(self) -> None:
        """Find out whose time leads, and give up what nobody waits for."""
        if self._clock.look(list(self._roster.sources.values())) and self._segment is not None:
            self._close_segment()
            self._break('clock_jump')
        for name in self._clock.newly_apart:
            self.counters.note(APART, text=f'{name.split()[0]} keeps another time than the others')
        now_ns = self._clock.now_ns
        active = {source.name for source in self._active()}
        idle = {one.name for one in self._roster.sources.values() if one.stream.n_pending} - active
        for source in self._roster.sources.values():
            source.expire()
            # What has just come may be the first of a source, and long.
            if source.name in idle & self._idle:
                source.stream.forget(source.stream.newest_ns - 2 * INTAKE.together_ns)
            self.counters.collect(source.set_aside)
        self._idle = idle
        if now_ns is not None:
            self.joints.expire(now_ns)
        self.counters.collect(self._joints_aside)

    def windows(self) -> Iterator[Window]:
        """Yield the windows that are complete."""
        yield from self._cutter.windows()

    def finish(self) -> Iterator[Window]:
        """Yield what is left: complete windows, then a partial one."""
        for source in self._roster.sources.values():
            source.flush(alone=self._clock.now_ns is None)
            self._note(source, 0)
        self.joints.flush()
        self._idle.clear()
        self._look()
        self._work(closing=True)
        self._close_segment()
        self._roster.clear()
        self._clock = LeadingClock()
        yield from self.windows()

    def _work(self, *, closing: bool) -> None:
        self._roster.meet()
        while True:
            if any(source.stream.jumped for source in self._roster.sources.values()):
                self._handle_jump(closing=closing)
            if self._segment is None and not self._begin(closing=closing):
                return
            if not self._advance(closing=closing):
                return

    def _begin(self, *, closing: bool) -> bool:
        """Begin a segment when a second of data is there."""
        begun = [
            source
            for source in self._leading()
            if source.stream.n_pending and not source.stream.jumped
        ]
        spans = {source.name: _span(source) for source in begun}
        if not begun:
            return False
        first = min(start for start, _ in spans.values())
        held_ns = max(end for _, end in spans.values()) - first
        silent = self._expected - {name.split()[0] for name in spans}
        waiting = [source for source in self._roster.sources.values() if source.is_waiting]
        least_ns = max(
            INTAKE.expect_ns if silent or waiting else INTAKE.start_ns,
            *(round(one.gate.awaited_s * NANOSECONDS_PER_SECOND) for one in waiting),
            0,
        )
        if not closing and held_ns < least_ns:
            return False
        together = [source for source in begun if spans[source.name][0] - first <= INTAKE.start_ns]
        for source in begun:
            self._rates.learn(source)
        self._rates.check(self._leading())
        timed = [source for source in together if source in self._active()]
        if not timed:
            return False
        reference = _reference(timed)
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

    def _leading(self) -> list[Source]:
        """Return the sources that keep the time of the record."""
        return [source for source in self._roster.confirmed if source.name in self._clock.leading]

    def _active(self) -> list[Source]:
        return [
            source
            for source in self._leading()
            if source.period_ns > 0.0
            and not self._rates.refuses(source)
            and not source.stream.jumped
        ]

    def _advance(self, *, closing: bool) -> bool:
        """Make the next stretch of rows; False when its samples are not there yet."""
        segment = self._segment
        if segment is None:
            return False
        for source in self._leading():
            if source.period_ns == 0.0:
                self._rates.learn(source)
        self._rates.check(self._leading())
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
        self._cutter.cut(segment, self._roster.confirmed)
        return self._check_rates()

    def _split(self, first_row: int, silent: np.ndarray) -> None:
        """End the segment where every source falls silent."""
        segment = self._segment
        if segment is None:
            return
        segment.n_rows = first_row + int(np.argmax(silent))
        resume = first_row + len(silent) - int(np.argmin(silent[::-1]))
        self._cutter.cut(segment, self._roster.confirmed)
        resume_ns = segment.time_ns(resume if not silent[-1] else first_row + len(silent))
        self._close_segment()
        self._resume(resume_ns)
        self._break('gap')

    def _resume(self, resume_ns: int) -> None:
        """Let the next segment begin at a time, and not with what the last one has used."""
        for source in self._roster.sources.values():
            source.stream.forget(resume_ns - round(source.period_ns / 2))

    def _check_rates(self) -> bool:
        segment = self._segment
        if segment is not None and segment.reference.rate_changed:
            segment.reference.rate_changed = False
            self._close_segment()
            self._resume(segment.time_ns(segment.n_rows))
            self._break('rate_change')
        return True

    def _close_segment(self) -> None:
        """Cut what is left of a segment as a partial window, and end the segment."""
        segment, self._segment = self._segment, None
        if segment is not None:
            self._cutter.cut_rest(segment, self._roster.confirmed)

    def _break(self, reason: str) -> None:
        """Note why the next segment begins."""
        self._segment = None
        self.counters.note(reason)
        self._cutter.flag(reason)

    def _handle_jump(self, *, closing: bool) -> None:
        """Begin anew when the clocks of most sources jumped back; else restart the odd one."""
        live = self._leading()
        jumped = [source for source in self._roster.sources.values() if source.stream.jumped]
        leading = [source for source in jumped if source in live]
        # From when the jump was told on: what tells it may take a second itself.
        waited = max(
            int(source.stream.jumped[-1].stamp_ns[-1] - source.stream.jumped[0].stamp_ns[-1])
            for source in jumped
        )
        if len(leading) < len(live) and waited < INTAKE.start_ns and not closing:
            return
        together = 2 * len(leading) > len(live)
        if together:
            self._close_segment()
            self._break('clock_jump')
            self.joints.clear()
            self._clock = LeadingClock()
        for source in live if together else jumped:
            if not together:
                source.flags.add('clock_jump')
            source.restart()
            self._note(source, source.stream.n_pending)


def _span(source: Source) -> tuple[int, int]:
    stamps = source.stream.samples().stamp_ns
    return int(stamps[0]), int(stamps[-1])


def _reference(sources: Sequence[Source]) -> Source:
    """Return the fastest source, of equals one that counts, then the first by name.

    Rates learned from a second of stamps differ by chance: that must not choose.
    """
    fastest_ns = min(source.period_ns for source in sources)
    equal = [one for one in sources if one.period_ns <= INTAKE.same_rate * fastest_ns]
    return min(equal, key=lambda source: (source.clock is None, source.name))
