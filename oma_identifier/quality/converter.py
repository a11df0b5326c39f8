"""Faults of a converter that no value alone shows: an overflow, and a sign that is missing.

An overflow in two's complement goes on at the other end of the range: the model of the samples
before is then wrong by the very range, and right once the range is added.  Without a sign the
values turn at zero, most often where the vibration is fastest, and none is beyond.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaincc

from oma_identifier.quality.prediction import innovations, lagged, ORDER, robust_innovations
from oma_identifier.quality.thresholds import QUALITY

SOME = 128
"""Values of a channel: few steps of a converter touch zero, and leap, without any fault."""

Real = NDArray[np.float64]


def leaps(signals: Real) -> NDArray[np.bool_]:
    """Tell which channels leap over most of their range, (n_channels, n_samples) array."""
    large = QUALITY.large_step * np.ptp(signals, axis=1, keepdims=True)
    steps = np.abs(signals[:, 1:] - signals[:, :-1])
    return np.asarray(np.count_nonzero(steps > large, axis=1) >= QUALITY.fewest_overflows)


def is_wrapped(signal: Real) -> bool:
    """Tell whether a channel that leaps overflows, and goes on at the other end of its range.

    Parameters
    ----------
    signal : (n_samples,) array [m/s²]
        As sent, finite.
    """
    full = float(np.ptp(signal))
    past = lagged(signal)
    if np.abs(innovations(past)).max() < QUALITY.large_step * full or is_coarse(signal):
        return False
    ends = [
        np.count_nonzero(signal < signal.min() + QUALITY.end * full) / len(signal),
        np.count_nonzero(signal > signal.max() - QUALITY.end * full) / len(signal),
    ]
    if sum(ends) > QUALITY.most_at_the_ends or min(ends) < QUALITY.fewest_at_an_end:
        return False
    error = robust_innovations(past)
    over = _overflows(np.abs(error) / full, often=bool(min(ends) > QUALITY.often_at_an_end))
    return len(over) >= QUALITY.fewest_overflows and _begin_at_an_end(past[-1], error, over)


def _overflows(size: Real, *, often: bool) -> NDArray[np.intp]:
    """Return the rows of innovations nearly the range; unless often, none large before them."""
    if often:
        return np.flatnonzero(size > QUALITY.nearly_the_range)
    n_large = np.concatenate([np.zeros(ORDER + 1), np.cumsum(size > QUALITY.large_before)])
    before = n_large[ORDER:-1] - n_large[: -1 - ORDER]
    return np.flatnonzero((size > QUALITY.nearly_the_range) & (before == 0.0))


def _begin_at_an_end(signal: Real, error: Real, over: NDArray[np.intp]) -> bool:
    """Tell whether leaps begin at the end opposite to where they lead, by what was predicted."""
    predicted = signal[over] - error[over]
    away = float(np.median(np.abs(predicted - np.median(signal)))) / float(np.ptp(signal))
    if not QUALITY.beyond[0] <= away <= QUALITY.beyond[1]:
        return False
    below = np.searchsorted(np.sort(signal), predicted) / len(signal)
    beyond = np.where(error[over] < 0.0, 1.0 - below, below)
    # Of predictions anywhere among the values these are uniform (Fisher's combined test).
    surprise = -np.log(np.maximum(beyond, 0.5 / len(signal))).sum()
    return bool(gammaincc(len(over), surprise) < QUALITY.overflow_chance)


def is_one_sided(signals: Real) -> NDArray[np.bool_]:
    """Tell which channels stay on one side of zero, (n_channels, n_samples) array."""
    return np.asarray((signals.min(axis=1) >= 0.0) | (signals.max(axis=1) <= 0.0))


def is_rectified(signal: Real) -> bool:
    """Tell whether a channel on one side of zero has no sign: many of its values are at it.

    Parameters
    ----------
    signal : (n_samples,) array [m/s²]
        As sent, finite.
    """
    size = np.abs(signal)
    reach = QUALITY.near_zero * size.std()
    near = np.count_nonzero(size < reach)
    far = np.count_nonzero(size > size.max() - reach)
    if near < max(QUALITY.touching_share * len(size), QUALITY.one_sided * far):
        return False
    return not is_coarse(size)


def is_coarse(signal: Real) -> bool:
    """Tell whether a channel takes too few values to tell a fault of the converter by."""
    some = signal[:SOME]
    return (
        len(np.unique(some)) <= QUALITY.coarse_levels
        and len(np.unique(signal)) <= QUALITY.coarse_levels
    )
