"""Health of the channels of one window: what is wrong with the samples, and who is left out."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modal_core.numbers.flat_tops import n_on_flat_top
from oma_identifier.quality.thresholds import QUALITY

NOISE_STRETCHES, NOISE_ROWS = 4, 256
MEDIAN_OF_GAUSSIAN = 0.6745
EXCLUDING = (
    'lost',
    'not_finite',
    'flatline',
    'clipping',
    'sample_and_hold',
    'wrapped',
    'rectified',
    'rows_reversed',
    'copied',
    'clock_unknown',
    'rate_mismatch',
    'missing',
)


@dataclass(frozen=True, slots=True)
class ChannelHealth:
    """Signal figures of one channel.

    Parameters
    ----------
    flags : tuple of str
        What was found.
    rms : float [m/s²]
        Without the mean.
    kurtosis : float
        Fourth central moment over the squared second; NaN of a flat line.
    noise_rms : float [m/s²]
        At most so much white noise.
    """

    flags: tuple[str, ...]
    rms: float
    kurtosis: float
    noise_rms: float


@dataclass(frozen=True, slots=True)
class Summary:
    """What the health of channels over a stretch is told from; stretches can be joined.

    Parameters
    ----------
    n_rows, n_parts : int
        Rows, and stretches that were joined.
    mean : (n_channels,) array [m/s²]
        Mean.
    sums : (3, n_channels) array
        Sums of second, third and fourth powers of the distance to the mean.
    extremes : (2, n_channels) array [m/s²]
        Lowest and highest value.
    n_extreme : (2, n_channels) int array
        Rows that have them.
    n_still : (n_channels,) int array
        Rows with the value of the row before, within the stretches.
    """

    n_rows: int
    n_parts: int
    mean: NDArray[np.float64]
    sums: NDArray[np.float64]
    extremes: NDArray[np.float64]
    n_extreme: NDArray[np.int64]
    n_still: NDArray[np.int64]


def summarise(values: NDArray[np.float64]) -> Summary:
    """Summarise one stretch, (n_rows, n_channels) array [m/s²], finite."""
    every = np.ones(len(values))
    mean = every @ values / len(values)
    centred = values - mean
    square = centred * centred
    extremes = np.array([values.min(axis=0), values.max(axis=0)])
    return Summary(
        n_rows=len(values),
        n_parts=1,
        mean=mean,
        sums=np.array(
            [every @ square]
            + [np.einsum('tc,tc->c', square, power) for power in (centred, square)]
        ),
        extremes=extremes,
        n_extreme=np.array([_count(values == extreme) for extreme in extremes]),
        n_still=_count(values[1:] == values[:-1]),
    )


def _count(true: NDArray[np.bool_]) -> NDArray[np.int64]:
    # Few are true, nearly always.
    n_columns = true.shape[1]
    return np.bincount(np.flatnonzero(true) % n_columns, minlength=n_columns)


def joined(parts: Sequence[Summary]) -> Summary:
    """Join the summaries of stretches that follow one another."""
    count = np.array([[part.n_rows] for part in parts])
    n_rows = int(count.sum())
    means = np.array([part.mean for part in parts])
    mean = (count * means).sum(axis=0) / n_rows
    second, third, fourth = np.array([part.sums for part in parts]).transpose(1, 0, 2)
    away = means - mean
    square = away**2
    extremes = np.array([part.extremes for part in parts])
    extreme = np.array([extremes[:, 0].min(axis=0), extremes[:, 1].max(axis=0)])
    n_extreme = np.array([part.n_extreme for part in parts])
    sums = [
        second + count * square,
        third + 3.0 * away * second + count * away * square,
        fourth + 4.0 * away * third + 6.0 * square * second + count * square**2,
    ]
    return Summary(
        n_rows=n_rows,
        n_parts=sum(part.n_parts for part in parts),
        mean=mean,
        sums=np.sum(sums, axis=1),
        extremes=extreme,
        n_extreme=np.sum(np.where(extremes == extreme, n_extreme, 0), axis=0),
        n_still=np.sum([part.n_still for part in parts], axis=0),
    )


def examine(values: NDArray[np.floating], summary: Summary) -> list[ChannelHealth]:
    """Look at the channels of a window.

    Parameters
    ----------
    values : (n_samples, n_channels) array [m/s²]
        Finite; looked at only where the summary leaves something open.
    summary : Summary
        Of the values.
    """
    n_rows = summary.n_rows
    power = summary.sums[0] / n_rows
    largest = np.abs(summary.extremes).max(axis=0)
    flat = power <= 1e-24 * (1.0 + largest**2)
    with np.errstate(invalid='ignore', divide='ignore'):
        kurtosis = np.where(flat, np.nan, summary.sums[2] / n_rows / power**2)
    noise = noise_rms(values)
    maybe_still = summary.n_still + summary.n_parts > QUALITY.flat_share * n_rows
    maybe_clipped = summary.n_extreme.sum(axis=0) >= _least_clipped(n_rows)
    found = []
    for place in range(len(power)):
        flags = []
        if flat[place]:
            flags = ['flatline']
        else:
            if maybe_still[place] and _is_still(values[:, place]):
                flags.append('flatline')
            share = share_clipped(_column(values, place)) if maybe_clipped[place] else 0.0
            if share > 0.0:
                harms = share > QUALITY.clipped_harms
                flags.append('clipping' if harms else 'clipped_seldom')
            if kurtosis[place] > QUALITY.impulsive_kurtosis:
                flags.append('impulsive')
        rms = float(np.sqrt(power[place]))
        found.append(ChannelHealth(tuple(flags), rms, float(kurtosis[place]), float(noise[place])))
    return found


def _column(values: NDArray[np.floating], place: int) -> NDArray[np.float64]:
    return np.ascontiguousarray(values[:, place], dtype=np.float64)


def noise_rms(values: NDArray[np.floating]) -> NDArray[np.float64]:
    """Return how much white noise each channel has at most, (n_channels,) array [m/s²].

    Second differences take out what is slow against the sample rate; of white noise of variance
    σ² they have 6 σ².  Their median tells it, so that knocks do not count.

    Parameters
    ----------
    values : (n_samples, n_channels) array [m/s²]
        A few short stretches of it are looked at.
    """
    starts = np.linspace(0, max(0, len(values) - NOISE_ROWS), NOISE_STRETCHES).astype(int)
    looked_at = [values[start : start + NOISE_ROWS].astype(np.float64) for start in starts]
    bends = [np.diff(rows, 2, axis=0) for rows in looked_at]
    if len(bends[0]) == 0:
        return np.full(values.shape[1], np.nan)
    size = np.median(np.abs(np.concatenate(bends)), axis=0)
    return np.asarray(size / (MEDIAN_OF_GAUSSIAN * np.sqrt(6.0)))


def _is_still(signal: NDArray[np.floating]) -> bool:
    return _longest_run(signal[1:] == signal[:-1]) > QUALITY.flat_share * len(signal)


def _least_clipped(n_rows: int) -> float:
    return max(QUALITY.clipped_at_least, QUALITY.clipped_share * n_rows)


def share_clipped(signal: NDArray[np.float64]) -> float:
    """Return the share of samples at a limit of the range, 0 where there is none to be seen."""
    least = _least_clipped(len(signal))
    n_piled = n_on_flat_top(signal) + n_on_flat_top(-signal)
    if n_piled >= least:
        return n_piled / len(signal)
    # A coarse converter repeats values everywhere; a limit repeats only its own, in runs.
    at_limits = [_at_steep_end(signal), _at_steep_end(-signal)]
    n_in_runs = sum(np.count_nonzero(limit[1:] & limit[:-1]) for limit in at_limits)
    if n_in_runs < least or n_in_runs <= np.count_nonzero(signal == np.median(signal)):
        return 0.0
    return sum(np.count_nonzero(limit) for limit in at_limits) / len(signal)


def _at_steep_end(signal: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return which samples are at the largest value; none where the next one is about as often."""
    at_end = signal == signal.max()
    below = signal[~at_end]
    n_next = np.count_nonzero(below == below.max()) if len(below) else 0
    steep = np.count_nonzero(at_end) > QUALITY.steeper_than_tone * n_next
    return np.asarray(at_end & steep)


def _longest_run(still: NDArray[np.bool_]) -> int:
    """Return how many samples in a row have one value."""
    changes = np.flatnonzero(~still)
    edges = np.concatenate([[-1], changes, [len(still)]])
    return int(np.diff(edges).max())
