"""Channels with the samples of another one: a copied column, or two names for one input."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from oma_identifier.quality.thresholds import QUALITY

COPIED = 'copied'


def copies(signals: Sequence[NDArray[np.floating]], extremes: NDArray[np.float64]) -> list[int]:
    """Return the places of channels whose samples are those of one before, in order.

    Noise differs from channel to channel, and so do converters' last bits: live channels never
    have equal samples by chance.

    Parameters
    ----------
    signals : sequence of (n_rows,) arrays [m/s²]
        Of the channels, none of them flat; looked at only where extremes are equal.
    extremes : (2, n_channels) array [m/s²]
        Lowest and highest value of each.
    """
    reach = QUALITY.copied_roundings * np.abs(extremes).max(axis=0, initial=0.0)
    found: list[int] = []
    for place, signal in enumerate(signals):
        rounding = np.finfo(signal.dtype).eps * reach[place]
        away = np.abs(extremes[:, :place] - extremes[:, [place]]).max(axis=0)
        alike = np.flatnonzero(away <= rounding).tolist()
        if any(np.abs(signals[other] - signal).max() <= rounding for other in alike):
            found.append(place)
    return found
