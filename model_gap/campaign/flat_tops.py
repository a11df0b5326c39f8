"""Channels that were driven past their range: a signal cut off piles up at its largest value."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from modal_core.numbers.flat_tops import n_on_flat_top
from model_gap.campaign.campaign import GapRecord
from model_gap.campaign.thresholds import CAMPAIGN


def flat_topped(records: Sequence[GapRecord], channels: Sequence[str]) -> tuple[str, ...]:
    """Return the channels whose samples pile up at their largest or smallest value.

    Parameters
    ----------
    records : sequence of GapRecord
        Of one campaign.
    channels : sequence of str
        Names of their columns.
    """
    found = np.zeros(len(channels), dtype=bool)
    for record in records:
        found |= [_is_cut_off(column) for column in record.acceleration.T]
    return tuple(name for name, flat in zip(channels, found, strict=True) if flat)


def _is_cut_off(column: NDArray[np.float64]) -> bool:
    return max(n_on_flat_top(column), n_on_flat_top(-column)) >= CAMPAIGN.fewest_flat
