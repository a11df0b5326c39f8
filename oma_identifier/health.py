"""Health of the channels of one window: what is wrong with the samples, and who is left out."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from modal_core.quality import ChannelQuality

CLIPPED_SHARE = 1e-3
"""Share of samples at the very same extreme value that only a limit can cause."""
CLIPPED_AT_LEAST = 8
FLAT_SHARE = 0.1
"""Share of the window without any change of value."""
IMPULSIVE_KURTOSIS = 30.0
GAIN_SUSPICION = 50.0
"""Times the median root mean square of its neighbours, or one over it."""
POLARITY_COHERENCE = 0.98
FEW_SAMPLES = 1024
"""Enough to tell a coherence of 0.98 from one of chance."""
EXCLUDING = ('lost', 'not_finite', 'flatline', 'clipping', 'missing')


@dataclass(frozen=True, slots=True)
class ChannelHealth:
    """Signal figures of one channel.

    Parameters
    ----------
    flags : tuple of str
        What was found.
    rms : float [m/s²]
        Without the mean.
    """

    flags: tuple[str, ...]
    rms: float


def examine(signal: NDArray[np.float64]) -> ChannelHealth:
    """Look at one channel of a window.

    Parameters
    ----------
    signal : (n_samples,) array [m/s²]
        Finite.
    """
    signal = np.ascontiguousarray(signal)  # a column of a window is slow to walk
    centred = signal - signal.mean()
    power = float(centred @ centred) / len(signal)
    rms = float(np.sqrt(power))
    if power <= 1e-24 * (1.0 + float(max(signal.max(), -signal.min())) ** 2):
        return ChannelHealth(('flatline',), rms)
    flags = []
    still = signal[1:] == signal[:-1]
    if still.any() and _longest_run(still) > FLAT_SHARE * len(signal):
        flags.append('flatline')
    if is_clipped(signal):
        flags.append('clipping')
    np.square(centred, out=centred)
    if float(centred @ centred) / len(signal) > IMPULSIVE_KURTOSIS * power**2:
        flags.append('impulsive')
    return ChannelHealth(tuple(flags), rms)


def is_clipped(signal: NDArray[np.float64]) -> bool:
    """Tell whether a channel runs into a limit: many samples in a row at one extreme value."""
    least = max(CLIPPED_AT_LEAST, CLIPPED_SHARE * len(signal))
    at_limits = [signal == extreme for extreme in (signal.max(), signal.min())]
    if sum(np.count_nonzero(at_limit) for at_limit in at_limits) < least:
        return False
    # A coarse converter repeats values everywhere; a limit repeats only its own, in runs.
    runs = [np.count_nonzero(at_limit[1:] & at_limit[:-1]) for at_limit in at_limits]
    if sum(runs) < least:
        return False
    middle = np.median(signal)
    return bool(sum(runs) > np.count_nonzero(signal == middle))


def _longest_run(still: NDArray[np.bool_]) -> int:
    """Return how many samples in a row have one value."""
    changes = np.flatnonzero(~still)
    edges = np.concatenate([[-1], changes, [len(still)]])
    return int(np.diff(edges).max())


def compare(
    values: NDArray[np.float64], qualities: Sequence[ChannelQuality]
) -> list[ChannelQuality]:
    """Flag channels whose gain or polarity does not fit their neighbours.

    These are suspicions for a person to check; nothing is corrected or excluded.

    Parameters
    ----------
    values : (n_samples, n_channels) array [m/s²]
        Healthy channels.
    qualities : sequence of ChannelQuality
        One per column.
    """
    if values.shape[1] < 3:
        return list(qualities)
    rms = np.array([quality.rms for quality in qualities])
    apart = ~np.eye(len(rms), dtype=bool)
    others = np.median(np.broadcast_to(rms, apart.shape)[apart].reshape(len(rms), -1), axis=1)
    spaced = values[:: max(1, len(values) // FEW_SAMPLES)]
    with np.errstate(invalid='ignore', divide='ignore'):
        correlation = np.atleast_2d(np.corrcoef(spaced.T))
    np.fill_diagonal(correlation, np.nan)
    opposite = np.nan_to_num(correlation).min(axis=1) < -POLARITY_COHERENCE
    checked = []
    for index, quality in enumerate(qualities):
        flags = list(quality.flags)
        if (
            rms[index] > GAIN_SUSPICION * others[index]
            or rms[index] * GAIN_SUSPICION < others[index]
        ):
            flags.append('gain_suspicion')
        if opposite[index]:
            flags.append('polarity_suspicion')
        checked.append(replace(quality, flags=tuple(flags)))
    return checked
