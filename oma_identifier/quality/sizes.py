"""Channels far larger or smaller than the others of their kind: a wrong unit or gain."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from modal_core.quality import ChannelQuality
from oma_identifier.quality.thresholds import QUALITY

SMALL, LARGE = 'small_suspicion', 'large_suspicion'


def check_sizes(channels: Sequence[ChannelQuality]) -> dict[str, str]:
    """Return a flag per channel whose rms is far from the median of those in its unit.

    What is far below and noise raises no suspicion: it does not move.

    Parameters
    ----------
    channels : sequence of ChannelQuality
        Those that take part, with their rms and noise.
    """
    flags: dict[str, str] = {}
    sizes = times_of_alike([each.rms for each in channels], [each.unit for each in channels])
    for channel, times in zip(channels, sizes, strict=True):
        if times > QUALITY.small_factor:
            flags[channel.name] = LARGE
        elif (
            times < 1.0 / QUALITY.small_factor
            and channel.noise_rms < QUALITY.mostly_noise * channel.rms
        ):
            flags[channel.name] = SMALL
    return flags


def times_of_alike(rms: Sequence[float], unit: Sequence[str]) -> NDArray[np.float64]:
    """Return each channel's rms over the median of those in its unit.

    Parameters
    ----------
    rms, unit : (n_channels,) sequence
        Of the channels.

    Returns
    -------
    (n_channels,) array
        NaN where too few channels tell what is usual; infinite where most do not move.
    """
    values, units = np.asarray(rms, dtype=float), np.asarray(unit)
    times = np.full(len(values), np.nan)
    for each in dict.fromkeys(unit):
        alike = units == each
        if np.count_nonzero(alike) >= QUALITY.fewest_alike:
            with np.errstate(divide='ignore', invalid='ignore'):
                times[alike] = values[alike] / np.median(values[alike])
    return times
