"""Rows that come in reversed order within every block or read-out of a buffer.

A vibration backwards is one as well, so within a block nothing shows; from block to block it
leaps.  What a short model does not predict then recurs with the length of the blocks, and turning
the blocks round makes it smaller.  Turning rows that are in order round makes it larger.
"""

from collections.abc import Iterator
from itertools import islice

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft

from oma_identifier.quality.converter import is_coarse
from oma_identifier.quality.prediction import innovations, lagged, ORDER
from oma_identifier.quality.thresholds import QUALITY

SHORTEST, LONGEST_BLOCK = 3, 512
"""Rows of a block."""
MOST_OF_SOURCE = 3
"""Of one source that are looked at; rows are reversed in all of them."""
TINY = 1e-9
MOST_LENGTHS = 6
"""Lengths that are tried: those that recur at least so much, by the strongest recurrence."""

Real = NDArray[np.float64]


def is_reversed(signals: Real) -> bool:
    """Tell whether rows come in reversed order within blocks of one length.

    Parameters
    ----------
    signals : (n_channels, n_samples) array [m/s²]
        Of one source, as sent, finite.
    """
    clear = list(islice((each for each in signals if not is_coarse(each)), MOST_OF_SOURCE))
    if not clear:
        return False
    rows = np.transpose(clear)
    power = _power(rows)
    recurrence = _recurrence(power)
    return any(
        _is_turned_back(power, recurrence[length], _turned(rows, first, length), length)
        for length in _lengths(recurrence, len(rows))
        for first in _borders(_course(power), length)
    )


def _is_turned_back(power: Real, recurrence: float, turned: Real, length: int) -> bool:
    """Tell whether rows are better predicted, and no longer leap, once blocks are turned round."""
    less = _power(turned)
    most = QUALITY.largest_power * np.median(power, axis=0)
    fall = np.minimum(power, most).mean(axis=0) / np.minimum(less, most).mean(axis=0)
    if np.median(fall) < QUALITY.less_power:
        return False
    return bool(_recurrence(less)[length] < QUALITY.recurrence_left * recurrence)


def _power(rows: Real) -> Real:
    """Return the power that is not predicted, (n_samples - ORDER, n_channels) array."""
    power = np.square([innovations(lagged(column)) for column in rows.T]).T
    return np.asarray(power + np.finfo(float).tiny)


def _course(power: Real) -> Real:
    """Return how badly rows are predicted by all channels, (n_rows,) array."""
    typical = np.median(power, axis=0) + TINY * power.mean(axis=0)
    return np.asarray(np.minimum(power / typical, QUALITY.largest_power).mean(axis=1))


def _recurrence(power: Real) -> Real:
    """Return the autocorrelation of it, in standard deviations of that of white noise."""
    course = _course(power)
    centred = course - course.mean()
    size = next_fast_len(len(centred) + LONGEST_BLOCK, real=True)
    spectrum = rfft(centred, size)
    recurrence = irfft(spectrum.real**2 + spectrum.imag**2, size)[: LONGEST_BLOCK + 1]
    return np.asarray(recurrence / recurrence[0] * np.sqrt(len(centred)))


def _lengths(recurrence: Real, n_rows: int) -> Iterator[int]:
    """Yield the steps after which the innovations recur, the likeliest first."""
    recurrence = recurrence[: n_rows // QUALITY.fewest_blocks]
    best = SHORTEST + int(np.argmax(recurrence[SHORTEST:]))
    if recurrence[best] < QUALITY.recurrence:
        return
    # The strongest may be of several blocks.
    parts = range(best // SHORTEST, 0, -1)
    lengths = dict.fromkeys(round(best / part) for part in parts)
    likely = [
        length
        for length in lengths
        if recurrence[length] >= QUALITY.recurs_alike * recurrence[best]
    ]
    yield from sorted(likely, key=lambda length: -recurrence[length])[:MOST_LENGTHS]


def _borders(course: Real, length: int) -> list[int]:
    """Return the likeliest first rows of a block."""
    whole = len(course) // length
    profile = course[: whole * length].reshape(whole, length).mean(axis=0)
    rise = profile - np.roll(profile, 1)
    return [int(place + ORDER) % length for place in np.argsort(rise)[:-3:-1]]


def _turned(rows: Real, first: int, length: int) -> Real:
    """Return the rows of whole blocks, each turned round."""
    whole = (len(rows) - first) // length
    blocks = rows[first : first + whole * length].reshape(whole, length, -1)
    return blocks[:, ::-1].reshape(whole * length, -1)
