"""Times for the samples of a recorder that counts them: its counter, led by its stamps."""

from collections import deque
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.measurements import NANOSECONDS_PER_SECOND, SampleBlock
from oma_identifier.time_axis.thresholds import TIME_AXIS


@dataclass(frozen=True, slots=True)
class BlockTimes:
    """What became of a block.

    Parameters
    ----------
    stamp_ns : (n_samples,) int64 array [ns]
        Time of each sample; empty for a repeated block.
    n_repeated : int
        Samples that came before.
    restarted : bool
        The counter or the clock does not continue.
    """

    stamp_ns: NDArray[np.int64]
    n_repeated: int = 0
    restarted: bool = False


class BlockClock:
    """Gives every sample of a block source its time.

    Block stamps come from a host and scatter; the counter does not.  Times follow the counter
    at the declared rate and are led slowly by the stamps, so that the recorder's clock may
    drift against the others.

    Parameters
    ----------
    sample_rate_hz : float [Hz]
        As declared.
    """

    def __init__(self, sample_rate_hz: float) -> None:
        self.sample_rate_hz = sample_rate_hz
        self._step_ns = NANOSECONDS_PER_SECOND / sample_rate_hz
        self._anchor: tuple[int, float] | None = None
        self._recent: deque[int] = deque(maxlen=TIME_AXIS.remembered_blocks)
        self._start = (0, 0)
        self._newest = (0, 0)
        self._sums = np.zeros((3, 3))

    def times(self, block: SampleBlock) -> BlockTimes:
        """Return the times of a block's samples."""
        n_samples = len(block.acceleration)
        if self._anchor is None:
            self._begin(block)
        if self._is_repeat(block):
            return BlockTimes(np.empty(0, dtype=np.int64), n_repeated=n_samples)
        fell = block.first_index < self._newest[0] - self.sample_rate_hz
        is_wrong = self.is_wrong
        restarted = self._is_off(block) and (fell or not is_wrong)
        if restarted:
            self._begin(block)
            self._recent.clear()
            is_wrong = self.is_wrong
        index, anchor_ns = self._anchor or (0, 0.0)
        start = anchor_ns + (block.first_index - index) * self._step_ns
        stamps = np.rint(start + self._step_ns * np.arange(n_samples)).astype(np.int64)
        share = 0.0 if is_wrong else min(1.0, n_samples * self._step_ns * 1e-9 / TIME_AXIS.slew_s)
        self._anchor = (index, anchor_ns + share * self._error(block))
        self._recent.append(block.first_index)
        if block.first_index > self._newest[0]:
            self._newest = (block.first_index, block.stamp_ns)
            self._note(block)
        return BlockTimes(stamps, restarted=restarted)

    @property
    def measured_rate_hz(self) -> float:
        """Rate of the counter against the stamps; the declared one until it is known [Hz]."""
        span_ns = self._newest[1] - self._start[1]
        if span_ns < TIME_AXIS.settled_s * NANOSECONDS_PER_SECOND:
            return self.sample_rate_hz
        return (self._newest[0] - self._start[0]) * NANOSECONDS_PER_SECOND / span_ns

    @property
    def is_wrong(self) -> bool:
        """The declared rate contradicts the stamps: the counter alone is followed."""
        off = abs(self.measured_rate_hz / self.sample_rate_hz - 1.0)
        return off > TIME_AXIS.rate_tolerance or self._runs_away()

    def _note(self, block: SampleBlock) -> None:
        """Sum up how the stamps depart from the declared rate [s]."""
        counted = (block.first_index - self._start[0]) / self.sample_rate_hz
        beside = (block.stamp_ns - self._start[1]) * 1e-9 - counted
        row = np.array([1.0, counted, beside])
        self._sums += np.outer(row, row)

    def _runs_away(self) -> bool:
        count, span_s = self._sums[0, 0], (self._newest[1] - self._start[1]) * 1e-9
        if count < TIME_AXIS.fewest_settled or span_s < TIME_AXIS.settled_s:
            return False
        mean = self._sums[0] / count
        spread = self._sums[1:, 1:] / count - np.outer(mean[1:], mean[1:])
        slope = spread[0, 1] / spread[0, 0]
        scatter = math.sqrt(max(0.0, spread[1, 1] - slope * spread[0, 1]))
        return bool(
            abs(slope) > max(TIME_AXIS.crystal_error, TIME_AXIS.out_of_scatter * scatter / span_s)
        )

    def _begin(self, block: SampleBlock) -> None:
        jump_ns = abs(self._error(block)) if self._anchor else math.inf
        self._anchor = (block.first_index, float(block.stamp_ns))
        # Small steps happen when the declared rate is wrong; then the count goes on.
        if jump_ns > TIME_AXIS.counter_step_ns or block.first_index <= self._newest[0]:
            self._start = self._newest = (block.first_index, block.stamp_ns)
            self._sums = np.zeros((3, 3))

    def _is_repeat(self, block: SampleBlock) -> bool:
        near = 0 <= self._newest[0] - block.first_index < self.sample_rate_hz
        return near and block.first_index in self._recent and not self._is_off(block)

    def _is_off(self, block: SampleBlock) -> bool:
        return abs(self._error(block)) > TIME_AXIS.stamp_error_ns

    def _error(self, block: SampleBlock) -> float:
        index, anchor_ns = self._anchor or (0, 0.0)
        return block.stamp_ns - (anchor_ns + (block.first_index - index) * self._step_ns)
