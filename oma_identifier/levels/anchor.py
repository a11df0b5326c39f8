"""Changes with the level by the motion in a band, the size of what changes by identified modes.

What moments and widths of a band tell holds at any level, but has a part of what a filter leaves
of other modes there, and of a force that is not white about the mode: alike at all levels, for
filter and band are the same.  Frequency and damping ratio as identified beside all other modes
have none of it, and are off where the level bends the peak.  So one factor for all levels brings
the one to the other, and levels count the less the more the mode has changed there.

References
----------
Hausman (1978), doi:10.2307/1913827: of two estimates that one record gives, the efficient one has
all in it that scatters both.
"""

from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from oma_identifier.levels.modal_motion import ModalMotion
from oma_identifier.levels.thresholds import LEVELS

Real = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Anchor:
    """What brings values of levels to those that were identified.

    Parameters
    ----------
    factor : float
    weight : (n,) array
        Of the levels in it.
    identified : (n,) array
        Relative variances of what was identified; infinite where it has none.
    shared : float
        Relative variance of the factor for what was identified.
    """

    factor: float
    weight: Real
    identified: Real
    shared: float

    def of(self, value: Real, std: Real, alike: Real | float = 0.0) -> tuple[Real, Real]:
        """Return values brought to their size, and their covariance.

        Parameters
        ----------
        value, std : (n,) arrays
            With what scatters from level to level.
        alike : (n,) array
            Relative standard deviations of what all have in common.
        """
        own = std / value
        shares = np.outer(alike, alike) + np.diag(own**2)
        # What values have beside all levels, and what that has in common with the identified.
        less = np.eye(len(value)) - self.weight
        both = less @ (self.weight * np.minimum(own**2, self.identified))
        relative = less @ shares @ less.T + self.shared + both[:, None] + both
        brought = self.factor * value
        return brought, relative * np.outer(brought, brought)


def anchor(value: Real, identified: Real, identified_std: Real, smallest: int) -> Anchor | None:
    """Return what brings values of levels to what was identified; None where that has no std.

    Parameters
    ----------
    value : (n,) array
        At each level.
    identified, identified_std : (n,) arrays
        The same as identified there; NaN: not known.
    smallest : int
        The level that moves least.
    """
    known = np.isfinite(identified) & (identified_std > 0.0)
    if not known.any():
        return None
    variance = np.where(known, identified_std / identified, np.inf) ** 2
    scatter = variance + (LEVELS.bent * (value / value[smallest] - 1.0)) ** 2
    weight = 1.0 / scatter
    weight /= weight.sum()
    apart = np.where(known, identified / value, 1.0)
    factor = float(weight @ apart)
    misfit = float(np.sum((apart / factor - 1.0) ** 2 / scatter)) / max(int(known.sum()) - 1, 1)
    shared = max(1.0, misfit) * float(weight[known] ** 2 @ scatter[known])
    return Anchor(factor, weight, variance, shared)


@dataclass(frozen=True, slots=True)
class LevelStiffness:
    """Stiffness at levels.

    Parameters
    ----------
    value : (n,) array [1/s²]
    covariance : (n, n) array
        NaN where no frequency has a standard deviation.
    off : float
        What moments are off the frequencies by, in half-widths of the mode: by more where much of
        what is in the band is motion of other modes.  NaN as above.
    """

    value: Real
    covariance: Real
    off: float

    @property
    def told(self) -> bool:
        """Whether what is in the band is the mode's own."""
        return abs(self.off) < LEVELS.most_off

    @property
    def std(self) -> Real:
        """Standard deviations, NaN where they are not known."""
        known = np.sqrt(np.diag(self.covariance))
        return known if self.told else np.full_like(known, math.nan)


def stiffness_at_levels(motions: Sequence[ModalMotion]) -> LevelStiffness:
    """Return the stiffness at each level.

    Parameters
    ----------
    motions : sequence of ModalMotion
        Of one mode.
    """
    value = np.array([each.stiffness for each in motions])
    hz = np.array([each.frequency_hz for each in motions])
    relative = 2.0 * np.array([each.frequency_std_hz for each in motions]) / hz
    square = (2.0 * math.pi * hz) ** 2
    found = anchor(value, square, relative * square, _smallest(motions))
    if found is None:
        return LevelStiffness(value, np.full((len(value), len(value)), math.nan), math.nan)
    std = np.array([each.stiffness_std for each in motions])
    ratio = float(np.median([each.damping_ratio for each in motions]))
    return LevelStiffness(
        *found.of(value, std, np.array([each.colour_std for each in motions])),
        0.5 * math.log(found.factor) / ratio,
    )


def width_anchor(motions: Sequence[ModalMotion]) -> Anchor:
    """Return what brings half-widths of the peak to those that were identified."""
    value = np.array([each.half_width_hz()[0] for each in motions])
    hz = np.array([each.frequency_hz for each in motions])
    ratio = np.array([(each.damping_ratio, each.damping_ratio_std) for each in motions]).T
    found = anchor(value, ratio[0] * hz, ratio[1] * hz, _smallest(motions))
    unknown = np.full(len(value), math.inf)
    return Anchor(1.0, np.zeros(len(value)), unknown, 0.0) if found is None else found


def _smallest(motions: Sequence[ModalMotion]) -> int:
    return int(np.argmin([each.displacement_m for each in motions]))
