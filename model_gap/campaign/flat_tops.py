"""Channels that were driven past their range: a signal cut off piles up at its largest value."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

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
        values = record.acceleration - np.median(record.acceleration, axis=0)
        found |= _piles_up(values) | _piles_up(-values)
    return tuple(name for name, flat in zip(channels, found, strict=True) if flat)


def _piles_up(values: NDArray[np.float64]) -> NDArray[np.bool_]:
    found = []
    for column in values.T:
        ordered = np.sort(column)
        top = ordered[-1]
        steps = np.diff(ordered)
        least = float(np.min(steps[steps > 0.0], initial=np.inf))
        if not top > 0.0 or not np.isfinite(least):
            found.append(False)
            continue
        layer = max(CAMPAIGN.clipped_layer * top, 1.01 * least)  # of a coarse converter: one step
        outermost = int(np.sum(ordered >= top - layer))
        next_few = int(np.sum(ordered >= top - CAMPAIGN.clipped_layers * layer)) - outermost
        found.append(
            outermost >= CAMPAIGN.fewest_flat and outermost > CAMPAIGN.piled_up * max(next_few, 1)
        )
    return np.array(found)
