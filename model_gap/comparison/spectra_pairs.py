"""Measured spectra beside those the model predicts, before and after."""

from collections.abc import Sequence
from dataclasses import dataclass
import itertools

import numpy as np
from numpy.typing import NDArray

from model_gap.campaign import CAMPAIGN, Complex, RecordSpectra
from model_gap.hypothesis import Hypothesis
from model_gap.search import Search


@dataclass(frozen=True)
class SpectraPair:
    """One recording.

    Parameters
    ----------
    item : RecordSpectra
        What was measured, and its noise.
    before, after : (n_channels, n_bins) complex array
        What the model says, as it was given and as it is now.
    """

    item: RecordSpectra
    before: Complex
    after: Complex

    @property
    def heldout(self) -> bool:
        """Took no part in the fit."""
        return bool(self.item.record.heldout)

    def inside(self, low_hz: float, high_hz: float) -> NDArray[np.bool_]:
        """Return which bins lie in a band."""
        frequency = self.item.frequency_hz
        return (frequency >= low_hz) & (frequency < high_hz)


def spectra_pairs(search: Search, after: Hypothesis) -> tuple[SpectraPair, ...]:
    """Predict every recording with the model as it was and as it is now."""
    found = []
    for predictor in (search.data.fitting, search.data.heldout):
        if not predictor.records:
            continue
        old = predictor.predict(search.nominal.cell())
        new = predictor.predict(after.cell())
        found += [
            SpectraPair(item, one, two)
            for item, one, two in zip(predictor.records, old, new, strict=True)
        ]
    return tuple(found)


def used_bands(pairs: Sequence[SpectraPair]) -> list[tuple[float, float]]:
    """Return the bands that hold data."""
    return [
        (low, high)
        for low, high in itertools.pairwise(CAMPAIGN.band_edges_hz)
        if any(pair.inside(low, high).any() for pair in pairs)
    ]
