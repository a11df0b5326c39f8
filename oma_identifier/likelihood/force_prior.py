"""A weak prior where one band says nothing of forces and noise."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from oma_identifier.likelihood.band_model import BandModel
from oma_identifier.likelihood.thresholds import LIKELIHOOD
from oma_identifier.likelihood.whittle_gradient import pairs

LEAST_LEVEL = 1e-6
"""Of the largest force, taken for the scale of another."""

NO_CURVATURE = 1e12
"""Weight of a prior that leaves none.  A band of 10⁶ lines and 60 channels, three octaves wide,
tells less than 10⁸: of each line and channel (x²/2)², x below 1.1."""

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class Prior:
    """A weak Gaussian prior on the forces of tails and on the noise, where a band says nothing.

    Far tails look alike within one band, so that their forces are not determined by its data, nor
    is the noise of a channel that the modes drown.  The standard deviation of a force entry is the
    geometric mean of the two force levels; that of the logarithm of the noise is
    ``noise_log_std``.
    """

    force: Complex
    noise: Real
    weight: Real

    @classmethod
    def of(cls, start: BandModel) -> 'Prior':
        """Return the prior that is centred on a model."""
        bent = LIKELIHOOD.slope_std / LIKELIHOOD.slope_reach
        rest = [LIKELIHOOD.slope_std**-2, bent**-2]
        rest += [LIKELIHOOD.noise_log_std**-2] * len(start.noise)
        if start.root is not None:
            # Centred on none: forces more than there are, and far tails, shall not wander.
            level = np.maximum(np.diag(start.force).real, LEAST_LEVEL * np.abs(start.force).max())
            own = np.repeat(1.0 / (LIKELIHOOD.root_variance * level), 2 * start.root.shape[1])
            weight = np.append(own, rest)
            return cls(start.force, start.noise, weight)
        # What a band made of the forces of far tails may be below zero: a scale must not be.
        level = np.abs(np.diag(start.force).real)
        level = np.maximum(level, LEAST_LEVEL * level.max())
        first, second = pairs(len(level))
        weight = np.where(second >= start.n_free, 1.0 / (level[first] * level[second]), 0.0)
        weight[first != second] *= 2.0
        return cls(
            start.force,
            start.noise,
            np.concatenate([weight, weight[first != second], rest]),
        )

    def of_one_slope(self) -> 'Prior':
        """Return the prior that has no curvature of the forces."""
        weight = self.weight.copy()
        weight[-len(self.noise) - 1] = NO_CURVATURE
        return replace(self, weight=weight)

    def offset(self, model: BandModel) -> Real:
        """Return centre minus model, in the order of the last parameters."""
        noise = np.log(self.noise / model.noise)
        slope = [-model.slope, -model.curvature]
        if model.root is not None:
            return np.concatenate(
                [-np.stack([model.root.real, model.root.imag], -1).ravel(), slope, noise]
            )
        difference = self.force - model.force
        first, second = pairs(len(difference))
        off = difference[first, second][first != second]
        return np.concatenate([difference[first, second].real, off.imag, slope, noise])

    def value(self, model: BandModel) -> float:
        """Return the negative logarithm of the prior."""
        return float(0.5 * np.sum(self.weight * self.offset(model) ** 2))
