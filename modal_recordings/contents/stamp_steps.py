"""Rate, scatter and gaps of samples from the steps between their stamps."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modal_core.measurements import NANOSECONDS_PER_SECOND

GAP_STEPS = 1.5
"""A step longer than this many nominal steps has lost at least one sample."""
COARSE_GAP_STEPS = 2.5
"""The same where stamps are coarser than samples: whole ticks, one and two in turn."""
LEAST_COARSE = 0.05
"""Share of steps of none, or of another number of ticks, that makes stamps coarse; fewer are
strays (``least_shared`` of the time axis)."""
WITHIN_TICKS = 2.0
"""Ticks over which stamps spread beside evenly counted samples: one by their rounding, and one by
which the mean step may be off from end to end."""
FEWEST_OTHER = 20
"""Steps of another number of ticks, per stretch without a gap, that tell: as many samples lost at
random spread beside their count by less than two steps in 1 of 10⁴ records (simulated)."""


@dataclass(frozen=True, slots=True)
class StampSteps:
    """What the steps between stamps tell.

    Parameters
    ----------
    rate_hz : float [Hz]
        Of the samples, gaps left out; 0: unknown.
    jitter_std_s : float [s]
        Scatter of the steps.
    is_gap : (n_steps,) bool array
        Steps with at least one sample lost.
    n_lost : (n_steps,) int array
        Samples that would have fitted in.
    is_coarse : bool
        Stamps are coarser than the samples: equal ones are no duplicates.
    """

    rate_hz: float
    jitter_std_s: float
    is_gap: NDArray[np.bool_]
    n_lost: NDArray[np.int64]
    is_coarse: bool


def stamp_steps(steps_ns: NDArray[np.int64]) -> StampSteps:
    """Return what steps tell.

    Samples of one stamp are samples, and a clock of 1 ms gives rows at 800 Hz steps of 1 ms and,
    every fourth, of 2 ms: there the median step is the tick of the clock, and the number of
    samples over the time tells the rate.

    Parameters
    ----------
    steps_ns : (n_steps,) array [ns]
        From each stamp to the next, in order of arrival.
    """
    forward = steps_ns[steps_ns > 0]
    if len(forward) == 0:
        nothing = np.zeros(len(steps_ns), dtype=np.int64)
        return StampSteps(0.0, 0.0, nothing.astype(bool), nothing, False)
    nominal = float(np.median(forward))
    is_counted = _is_even_by_count(steps_ns, nominal)
    n_equal = int(np.count_nonzero(steps_ns == 0))
    is_coarse = is_counted or n_equal > LEAST_COARSE * len(steps_ns)
    is_gap = steps_ns > (COARSE_GAP_STEPS if is_counted else GAP_STEPS) * nominal
    regular = steps_ns[~is_gap & (steps_ns >= (0 if is_coarse else 1))]
    period = float(regular.mean())
    usual = nominal if is_coarse else period
    lost = np.maximum(1, np.rint((steps_ns - usual) / period)).astype(np.int64)
    return StampSteps(
        rate_hz=NANOSECONDS_PER_SECOND / period,
        jitter_std_s=float(regular.std()) * 1e-9,
        is_gap=is_gap,
        n_lost=np.where(is_gap, lost, 0),
        is_coarse=is_coarse,
    )


def _is_even_by_count(steps: NDArray[np.int64], nominal: float) -> bool:
    """Tell whether whole ticks of different number are those of evenly spaced samples."""
    within = np.abs(steps) <= COARSE_GAP_STEPS * nominal
    n_other = np.count_nonzero(np.abs(steps[within] - nominal) > 0.5 * nominal)
    begins = np.concatenate([[0], np.flatnonzero(~within)])
    if n_other <= max(LEAST_COARSE * len(steps), FEWEST_OTHER * len(begins)):
        return False
    tick = int(np.gcd.reduce(steps[within]))
    beside = np.cumsum(np.where(within, steps - float(steps[within].mean()), 0.0))
    spread = np.maximum.reduceat(beside, begins) - np.minimum.reduceat(beside, begins)
    return bool(np.all(spread <= WITHIN_TICKS * tick))
