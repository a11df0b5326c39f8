"""Channels far larger or smaller than the others of their kind: a wrong unit or gain."""

from collections.abc import Sequence

import numpy as np

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
    for unit in {channel.unit for channel in channels}:
        alike = [channel for channel in channels if channel.unit == unit]
        if len(alike) < QUALITY.fewest_alike:
            continue
        middle = float(np.median([channel.rms for channel in alike]))
        least, most = middle / QUALITY.small_factor, middle * QUALITY.small_factor
        flags |= {channel.name: LARGE for channel in alike if channel.rms > most}
        flags |= {
            channel.name: SMALL
            for channel in alike
            if channel.rms < least and channel.noise_rms < QUALITY.mostly_noise * channel.rms
        }
    return flags
