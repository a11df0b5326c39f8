"""What bands say about the slope of the force density in other bands.

The slope changes slowly over the logarithm of frequency; one band alone knows it badly, and
guessing it costs information on the frequencies.  Where a force ends, as behind a low-pass filter,
it does neither: such a slope is no guess for other bands, nor is one slope enough for its own.
"""

from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from oma_identifier.likelihood.band_model import BandFit, SlopePrior
from oma_identifier.likelihood.thresholds import LIKELIHOOD

LEAST_PRECISION = 1e-3


@dataclass(frozen=True, slots=True)
class ForceSlope:
    """What the data of one band alone say about its slope.

    Parameters
    ----------
    place : float
        ln f in the middle of the band.
    value, precision : float
        The exponent of the force density over frequency, and one over its variance.
    """

    place: float
    value: float
    precision: float

    @classmethod
    def of(cls, fit: BandFit) -> 'ForceSlope':
        """Return the slope of a fit, freed of the prior that it was drawn to."""
        prior = fit.model.slope_prior
        known, before = fit.slope_std**-2.0, prior.std**-2.0
        precision = max(known - before, LEAST_PRECISION)
        drawn = fit.model.slope - prior.mean
        value = prior.mean + drawn * (precision + before) / precision
        return cls(math.log(fit.model.reference_hz), value, precision)

    @property
    def is_steep(self) -> bool:
        """Whether it contradicts what is assumed of slopes before the data."""
        expected = math.sqrt(LIKELIHOOD.slope_std**2 + 1.0 / self.precision)
        return abs(self.value) - LIKELIHOOD.integrated_twice > LIKELIHOOD.steep * expected


def pooled_slopes(slopes: Sequence[ForceSlope], places: Sequence[float]) -> list[SlopePrior]:
    """Return for each band what the slopes of the others say about its own.

    Gaussian process regression, the slopes of each band left out in turn.  Where one is steep the
    others say nothing: any slope up to that one may be.

    Parameters
    ----------
    slopes : sequence of ForceSlope
        Of the bands, or of such bands in another stretch.
    places : sequence of float
        ln f in the middle of the bands; NaN where nothing is asked.
    """
    centres = np.array(places, dtype=float)
    if steep := [abs(slope.value) for slope in slopes if slope.is_steep]:
        return [SlopePrior(std=max(steep))] * len(centres)
    if len(slopes) < 2 or not np.isfinite(centres).any():
        return [SlopePrior()] * len(centres)
    place = np.array([slope.place for slope in slopes])
    value = np.array([slope.value for slope in slopes])
    variance = 1.0 / np.array([slope.precision for slope in slopes])
    own = np.nanargmin(np.abs(place[:, None] - centres), axis=1)
    pooled = []
    for band, centre in enumerate(centres):
        others = own != band
        if not math.isfinite(centre) or not others.any():
            pooled.append(SlopePrior())
            continue
        cross = _kernel(place[others] - centre)
        noisy = _kernel(np.subtract.outer(place[others], place[others]))
        weight = np.linalg.solve(noisy + np.diag(variance[others]), cross)
        std = math.sqrt(max(LIKELIHOOD.slope_std**2 - float(weight @ cross), 1e-4))
        pooled.append(SlopePrior(float(weight @ value[others]), std))
    return pooled


def _kernel(distance: NDArray[np.float64]) -> NDArray[np.float64]:
    decay = np.exp(-0.5 * (distance / LIKELIHOOD.slope_reach) ** 2)
    return np.asarray(LIKELIHOOD.slope_std**2 * decay)
