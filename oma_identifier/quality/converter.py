"""Faults of a converter that no value alone shows: an overflow, and a sign that is missing.

An overflow in two's complement goes on at the other end of the range: the model of the samples
before is then wrong by the very range, and right once the range is added.  Without a sign the
values turn at zero, most often where the vibration is fastest, and none is beyond.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaincc

from oma_identifier.quality.prediction import innovations, lagged, ORDER, robust_innovations

LARGE_STEP = 0.6
"""Of the range: where no neighbours are farther apart there is no overflow to look for."""
NEARLY_THE_RANGE = 0.7
"""Of the range: an innovation that adding the range makes smaller by more than half."""
LARGE_BEFORE = 0.4
"""Of the range: what is predicted from such a sample says nothing of the next."""
END = 0.1
"""Of the range: what lies at either end."""
MOST_AT_THE_ENDS = 0.35
"""Share of the samples at both ends: a tone has 0.41, a square wave all, and leaps without fault;
what wraps has less than 0.25."""
FEWEST_AT_AN_END, OFTEN_AT_AN_END = 0.007, 0.04
"""Share of the samples at one end.  What wraps goes on there (a Gaussian that wraps beyond three
standard deviations: 0.008); single knocks fill no end."""
FEWEST_OVERFLOWS = 2
BEYOND = (0.2, 0.7)
"""Median distance of predictions from the middle, of the range: overflows are measured to begin
0.22 to 0.64 away, knocks nearer, and what a model cannot follow is farther."""
BY_CHANCE = 1e-4
"""Probability that predictions amid knocks, anywhere among the values, lie so near an end."""
NEAR_ZERO = 0.1
"""Of the standard deviation: a Gaussian without sign has 0.048 of its samples so near to zero."""
TOUCHING_SHARE = 0.02
ONE_SIDED = 4.0
"""Times as many samples lie near zero as near the other end; of a healthy channel whose offset
happens to be its amplitude as many (a Gaussian without sign: above ten)."""
COARSE_LEVELS, SOME = 24, 128
"""Values of a channel: few steps of a converter touch zero, and leap, without any fault."""

Real = NDArray[np.float64]


def is_wrapped(signal: Real) -> bool:
    """Tell whether a channel's overflows go on at the other end of its range.

    Parameters
    ----------
    signal : (n_samples,) array [m/s²]
        As sent, finite.
    """
    full = float(np.ptp(signal))
    if np.count_nonzero(np.abs(np.diff(signal)) > LARGE_STEP * full) < FEWEST_OVERFLOWS:
        return False
    past = lagged(signal)
    if np.abs(innovations(past)).max() < LARGE_STEP * full or is_coarse(signal):
        return False
    ends = [
        np.count_nonzero(signal < signal.min() + END * full) / len(signal),
        np.count_nonzero(signal > signal.max() - END * full) / len(signal),
    ]
    if sum(ends) > MOST_AT_THE_ENDS or min(ends) < FEWEST_AT_AN_END:
        return False
    error = robust_innovations(past)
    over = _leaps(np.abs(error) / full, often=bool(min(ends) > OFTEN_AT_AN_END))
    return len(over) >= FEWEST_OVERFLOWS and _begin_at_an_end(past[-1], error, over)


def _leaps(size: Real, *, often: bool) -> NDArray[np.intp]:
    """Return the rows of innovations nearly the range; unless often, none large before them."""
    if often:
        return np.flatnonzero(size > NEARLY_THE_RANGE)
    n_large = np.concatenate([np.zeros(ORDER + 1), np.cumsum(size > LARGE_BEFORE)])
    before = n_large[ORDER:-1] - n_large[: -1 - ORDER]
    return np.flatnonzero((size > NEARLY_THE_RANGE) & (before == 0.0))


def _begin_at_an_end(signal: Real, error: Real, over: NDArray[np.intp]) -> bool:
    """Tell whether leaps begin at the end opposite to where they lead, by what was predicted."""
    predicted = signal[over] - error[over]
    away = float(np.median(np.abs(predicted - np.median(signal)))) / float(np.ptp(signal))
    if not BEYOND[0] <= away <= BEYOND[1]:
        return False
    below = np.searchsorted(np.sort(signal), predicted) / len(signal)
    beyond = np.where(error[over] < 0.0, 1.0 - below, below)
    # Of predictions anywhere among the values these are uniform (Fisher's combined test).
    surprise = -np.log(np.maximum(beyond, 0.5 / len(signal))).sum()
    return bool(gammaincc(len(over), surprise) < BY_CHANCE)


def is_rectified(signal: Real) -> bool:
    """Tell whether a channel has no sign: all its values on one side of zero, many at it.

    Parameters
    ----------
    signal : (n_samples,) array [m/s²]
        As sent, finite.
    """
    if signal.min() < 0.0 < signal.max():
        return False
    size = np.abs(signal)
    reach = NEAR_ZERO * size.std()
    near = np.count_nonzero(size < reach)
    far = np.count_nonzero(size > size.max() - reach)
    if near < max(TOUCHING_SHARE * len(size), ONE_SIDED * far):
        return False
    return not is_coarse(size)


def is_coarse(signal: Real) -> bool:
    """Tell whether a channel takes too few values to tell a fault of the converter by."""
    some = signal[:SOME]
    return len(np.unique(some)) <= COARSE_LEVELS and len(np.unique(signal)) <= COARSE_LEVELS
