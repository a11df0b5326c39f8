"""One sensor or recorder: its channels, its samples in order, and its place on the grid."""

from collections import Counter
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from modal_core.channel import Channel
from modal_core.measurements import NANOSECONDS_PER_SECOND, SampleBlock, StampedSamples
from oma_identifier.intake.reach import reach_after, reach_before
from oma_identifier.intake.source_channels import columns_of
from oma_identifier.intake.step_count import StepCount
from oma_identifier.intake.thresholds import INTAKE
from oma_identifier.quality import ConverterWatch, RepeatWatch
from oma_identifier.time_axis import (
    BlockClock,
    BlockGate,
    count,
    FarValues,
    GridRows,
    is_coarse,
    make_lattice,
    margin_ns,
    measured,
    on_grid,
    OrderedSamples,
    Passed,
    SourceStream,
    tells_rate,
    tick_of,
    TIME_AXIS,
    typical_step,
)


@dataclass
class Source:
    """One source of responses.

    Parameters
    ----------
    name : str
        Topic.
    channels : tuple of Channel
        One per column that is used.
    columns : slice or tuple of int
        Columns of the samples that are used.
    gyroscopes : bool
        Whether angular velocities follow the accelerations of a sensor.
    sent : tuple of str
        What tells sources of one topic apart: names of all columns of a block, in the order of the
        first; frame id of a sensor.
    stream : SourceStream
        Its samples in order.
    clock : BlockClock or None
        For a source that counts its samples.
    period_ns : float [ns]
        Step between samples; 0 until it is known.
    unclear_ns : list of int [ns]
        Starts of stretches whose stamps do not tell when the samples were taken.
    changed_ns : list of int [ns]
        Starts of stretches that have another rate than before.
    jitter_std_s, phase : float
        Of the newest stretch: scatter of the stamps [s], lattice beside the grid [steps].
    """

    name: str
    channels: tuple[Channel, ...]
    columns: slice | tuple[int, ...]
    sent: tuple[str, ...]
    stream: SourceStream
    clock: BlockClock | None = None
    gyroscopes: bool = False
    period_ns: float = 0.0
    jitter_std_s: float = 0.0
    rate_changed: bool = False
    unclear_ns: list[int] = field(default_factory=list)
    changed_ns: list[int] = field(default_factory=list)
    flags: set[str] = field(default_factory=set)
    repeats: RepeatWatch = field(init=False)
    converter: ConverterWatch = field(init=False)
    far_values: FarValues = field(init=False)
    gate: BlockGate = field(init=False)
    _scale: NDArray[np.float64] | None = None
    _steps: StepCount = field(default_factory=StepCount)
    _reach_ns: int = 0
    _seen_ns: int = 0

    def __post_init__(self) -> None:
        """Count what the gate sets aside where the stream counts; watch all channels."""
        self.repeats = RepeatWatch(len(self.channels))
        self.converter = ConverterWatch(len(self.channels))
        self.far_values = FarValues(len(self.channels))
        self.gate = BlockGate(self.set_aside)
        scale = np.array([channel.scale for channel in self.channels])
        self._scale = None if (scale == 1.0).all() else scale

    @property
    def set_aside(self) -> 'Counter[str]':
        """Messages that others do not confirm, by reason."""
        return self.stream.set_aside

    @property
    def names(self) -> set[str]:
        """Names of the channels."""
        return {channel.name for channel in self.channels}

    @property
    def is_waiting(self) -> bool:
        """Whether messages came, but none that others confirm."""
        return self.stream.first_ns is None and (self.gate.is_waiting or self.stream.is_waiting)

    @property
    def rate_hz(self) -> float:
        """Samples per second."""
        return NANOSECONDS_PER_SECOND / self.period_ns if self.period_ns else 0.0

    @property
    def measured_rate_hz(self) -> float:
        """Samples per second, by all stamps so far."""
        if self.clock is not None:
            return self.clock.measured_rate_hz
        return self._steps.rate_hz or self.rate_hz

    def sends(self, measurement: StampedSamples | SampleBlock) -> bool:
        """Tell whether a measurement of the same topic is of this source."""
        sent = sent_by(measurement)
        same = sent == self.sent or (len(sent) == len(self.sent) and set(sent) == set(self.sent))
        return same and (self.clock is not None) == isinstance(measurement, SampleBlock)

    def add_stamped(self, samples: StampedSamples) -> None:
        """Take in per-sample messages."""
        values = columns_of(samples, gyroscopes=self.gyroscopes)
        self.stream.add(samples.stamp_ns, self._in_si(values[:, self.columns]))

    def add_block(self, block: SampleBlock) -> None:
        """Take in a block, when others confirm it; its columns may come in any order."""
        if block.channel_names != self.sent:
            order = [block.channel_names.index(name) for name in self.sent]
            values = block.acceleration[:, order]
            block = replace(block, channel_names=self.sent, acceleration=values)
        if self.clock is not None:
            self._pass(self.gate.admit(block))

    def flush(self, *, alone: bool) -> None:
        """Take in what waits, at the end of a record too short to confirm anything."""
        passed = self.gate.flush(alone=alone)
        if passed.blocks:
            self.flags.add('rate_unconfirmed')
        self._pass(passed)
        self.stream.flush(alone=alone)

    def expire(self) -> None:
        """Drop what has waited in vain to be confirmed."""
        self.gate.expire()
        self.stream.expire()

    def _pass(self, passed: Passed) -> None:
        rate_hz = None if self.clock is None else self.clock.sample_rate_hz
        if rate_hz and passed.anew and passed.blocks[0].sample_rate_hz == rate_hz:
            self.clock = BlockClock(rate_hz)
            self.flags.add('clock_jump')
        for block in passed.blocks:
            self._take(block)

    def _take(self, block: SampleBlock) -> None:
        """Give the samples of a block their times; another rate or a new clock is marked."""
        if self.clock is None:
            return
        if block.sample_rate_hz != self.clock.sample_rate_hz:
            self.clock = BlockClock(block.sample_rate_hz)
            self.period_ns = NANOSECONDS_PER_SECOND / block.sample_rate_hz
            self.rate_changed = self.stream.first_ns is not None
        times = self.clock.times(block)
        if times.n_repeated:
            self.stream.events.duplicates += [block.stamp_ns] * times.n_repeated
            return
        if times.restarted:
            self.flags.add('clock_jump')
        # A copy: what came with the block may be part of a file or a message.
        values = block.acceleration[:, self.columns].astype(self.stream.dtype)
        self.stream.add(times.stamp_ns, self._in_si(values), confirmed=True)

    def _in_si(self, values: NDArray[np.floating]) -> NDArray[np.floating]:
        """Return values in the units of the channels."""
        return values if self._scale is None else values * self._scale.astype(values.dtype)

    def restart(self) -> None:
        """Go on with what came after the clock jumped back."""
        later = self.stream.jumped
        first_ns = int(later[0].stamp_ns[0]) if later else 0
        self.repeats.restart(first_ns)
        self.converter.restart(first_ns)
        self.unclear_ns = [start for start in self.unclear_ns if start < first_ns]
        events = self.stream.events
        self.stream = SourceStream(len(self.channels), self.set_aside, self.stream.dtype)
        self.stream.events = events
        self._steps, self._seen_ns = StepCount(), 0
        for number, part in enumerate(later):
            confirmed = number == 0 or self.clock is not None
            self.stream.add(part.stamp_ns, part.values, confirmed=confirmed)

    def learn_period(self) -> None:
        """Take the step from the stamps held, when enough are there."""
        if self.clock is not None:
            self.period_ns = NANOSECONDS_PER_SECOND / self.clock.sample_rate_hz
            return
        stamps = self.stream.samples().stamp_ns
        if len(stamps) >= 4:
            # Of the first second only: how much more has arrived must not matter.
            stamps = stamps[: max(4, int(np.searchsorted(stamps, stamps[0] + INTAKE.learn_ns)))]
            coarse = is_coarse(stamps)
            counted = count(stamps) if coarse else None
            if coarse and counted is None:
                return
            self._reach_ns = 2 * int(counted.reach_ns) if counted else 0
            self.period_ns = counted.period_ns if counted else _mean_step(stamps)

    def on_grid(self, start_ns: int, n_rows: int, step_ns: float) -> GridRows:
        """Return the samples at ``n_rows`` times of the common grid.

        Parameters
        ----------
        start_ns : int [ns]
            Time of the first row.
        n_rows : int
            Rows.
        step_ns : float [ns]
            Step of the grid.
        """
        grid_ns = step_ns * np.arange(n_rows, dtype=np.float64)
        end_ns = start_ns + round(n_rows * step_ns)
        held = self._near(start_ns, int(grid_ns[-1]), step_ns)
        sent = self._without_far(held, start_ns, end_ns)
        timed = self._timed(sent, start_ns)
        samples = timed if sent is held else _recorded(timed)
        inside = _between(samples, start_ns, end_ns)
        fresh = self._unseen(samples, start_ns, end_ns)
        seen = measured(fresh.values)
        self.repeats.add(fresh.stamp_ns, seen)
        self.converter.add(fresh.stamp_ns, seen)
        self._follow_rate(inside.stamp_ns)
        uniform = self.clock is not None or timed is not sent
        tick_ns = 0 if uniform else tick_of(samples.stamp_ns)
        lattice = make_lattice(samples, start_ns, self.period_ns, uniform=uniform, tick_ns=tick_ns)
        if lattice is None:
            return GridRows.nothing(n_rows, len(self.channels))
        self.jitter_std_s = lattice.jitter_std_s
        return on_grid(lattice, grid_ns, self.cutoff(step_ns))

    def _without_far(self, held: OrderedSamples, start_ns: int, end_ns: int) -> OrderedSamples:
        """Return samples with values far outside of all others as no numbers."""
        far = self.far_values.mark(held.stamp_ns, held.values, start_ns, end_ns)
        if not far.any():
            return held
        lost = np.array(np.nan, held.values.dtype)
        return OrderedSamples(held.stamp_ns, np.where(far, lost, held.values))

    def _unseen(self, samples: OrderedSamples, start_ns: int, end_ns: int) -> OrderedSamples:
        """Return the samples of a stretch; where two join, each sample once and none left out.

        The ends of stretches are times of the grid: of a sample there, chance would decide.
        """
        joins = abs(start_ns - self._seen_ns) < 3.0 * self.period_ns
        fresh = _between(samples, self._seen_ns + 1 if joins else start_ns, end_ns)
        if len(fresh.stamp_ns):
            self._seen_ns = int(fresh.stamp_ns[-1])
        return fresh

    def forget(self, before_ns: int) -> None:
        """Drop what was found before a time."""
        self.stream.events.forget(before_ns)
        self.repeats.forget(before_ns)
        self.converter.forget(before_ns)
        self.far_values.forget(before_ns)
        self.unclear_ns = [start for start in self.unclear_ns if start >= before_ns]
        self.changed_ns = [start for start in self.changed_ns if start >= before_ns]

    def cutoff(self, step_ns: float) -> float:
        """Return the pass band on a grid, as a share of the source's own."""
        ratio = self.period_ns / step_ns
        # Clocks of the same nominal rate differ a little; that is not another rate.
        return 1.0 if ratio > 0.99 else ratio

    def margin_ns(self, step_ns: float) -> int:
        """Return how much later than the grid samples must be there [ns]."""
        if self.clock is not None and self.cutoff(step_ns) >= 1.0:
            same = abs(self.period_ns / step_ns - 1.0) < 1e-9
            if same:
                # What follows tells whether one far value is alone.
                return int((1 + TIME_AXIS.rest_beside) * self.period_ns)
        return margin_ns(self.period_ns, self.cutoff(step_ns)) + self._reach_ns

    def _timed(self, held: OrderedSamples, start_ns: int) -> OrderedSamples:
        """Return samples at strictly increasing times; those no stamps tell are noted."""
        if self.clock is not None:
            return held
        if not is_coarse(held.stamp_ns):
            self.flags.discard('coarse_stamps')
            apart = np.diff(held.stamp_ns, prepend=-1) != 0
            return (
                held if apart.all() else OrderedSamples(held.stamp_ns[apart], held.values[apart])
            )
        self.flags.add('coarse_stamps')
        counted = count(held.stamp_ns)
        if counted is None or not counted.is_sure:
            self.unclear_ns.append(start_ns)
        if counted is None:
            return OrderedSamples(held.stamp_ns[:0], held.values[:0])
        self.period_ns = counted.period_ns
        return OrderedSamples(counted.stamp_ns, held.values)

    def _near(self, start_ns: int, length_ns: int, step_ns: float) -> OrderedSamples:
        held = self.stream.samples()
        # Not one sample more to the right than was waited for: how many more have arrived by
        # chance must not matter.
        margin = margin_ns(self.period_ns, self.cutoff(step_ns))
        before = start_ns - margin - self._reach_ns - int(40 * self.period_ns)
        after = start_ns + length_ns + self.margin_ns(step_ns)
        before = reach_before(held, start_ns, before, self.period_ns)
        after = reach_after(held, start_ns + length_ns, after, self.period_ns)
        first, last = np.searchsorted(held.stamp_ns, [before, after])
        return OrderedSamples(held.stamp_ns[first:last], held.values[first:last])

    def awaits(self, end_ns: int, step_ns: float) -> bool:
        """Tell whether a gap across the end of a stretch wants more samples behind it."""
        last_ns = end_ns - round(step_ns)
        after_ns = last_ns + self.margin_ns(step_ns)
        held = self.stream.samples()
        return self.stream.newest_ns < reach_after(held, last_ns, after_ns, self.period_ns)

    def _follow_rate(self, inside: NDArray[np.int64]) -> None:
        if self.clock is not None:
            return
        if len(inside) >= INTAKE.fewest_for_rate:
            step = _mean_step(inside)
            if abs(step / self.period_ns - 1.0) > INTAKE.rate_change and tells_rate(inside, step):
                self.period_ns = step
                self.rate_changed = True
                self.changed_ns.append(int(inside[0]))
                self._steps = StepCount()
        self._steps.add(inside, self.period_ns)


def sent_by(measurement: StampedSamples | SampleBlock) -> tuple[str, ...]:
    """Return what tells sources of one topic apart: names of a block's columns, or the frame."""
    if isinstance(measurement, SampleBlock):
        return measurement.channel_names
    return (measurement.frame_id,)


def _mean_step(stamps: NDArray[np.int64]) -> float:
    """Return the mean step between neighbours, gaps left out [ns]."""
    steps = np.diff(stamps)
    typical = typical_step(steps)
    # Stamps in whole milliseconds may alternate between 2 and 3 of them.
    return float(np.mean(steps[steps < 1.51 * typical]))


def _recorded(samples: OrderedSamples) -> OrderedSamples:
    """Return the rows with any number: where there is none a recorder paused.

    Of one channel alone a value that is lost and a pause look alike: it is lost.
    """
    kept = ~np.isnan(samples.values).all(axis=1)
    if samples.values.shape[1] == 1 or kept.all():
        return samples
    return OrderedSamples(samples.stamp_ns[kept], samples.values[kept])


def _between(samples: OrderedSamples, start_ns: int, end_ns: int) -> OrderedSamples:
    first, last = np.searchsorted(samples.stamp_ns, [start_ns, end_ns])
    return OrderedSamples(samples.stamp_ns[first:last], samples.values[first:last])
