"""How sure a limiting depth is: from the uncertainty of modes and of cutting coefficients.

Samples of both give samples of the limit; the chance of chatter at a depth is the share of samples
whose limit is no deeper.  A straight line through the limits of small steps gives the deviation
at a fraction of the cost; between two lobes, where the limit has a kink, it says too little.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
import math

import numpy as np
from numpy.typing import NDArray

from machining.cut import Cut
from machining.stability.zeroth_order import Limits
from modal_core.errors import SettingsError
from modal_core.tool_modes import ToolModes

Real = NDArray[np.float64]
LimitsOf = Callable[[ToolModes, Cut], Limits]
STEP = 0.2
"""Of a standard deviation: lobes are curved over one."""


@dataclass(frozen=True, slots=True)
class LimitSample:
    """Limits of samples of all that is uncertain.

    Parameters
    ----------
    speed_rpm : (n_speeds,) array
    depth_m : (n_samples, n_speeds) array [m]
        inf where a sample never chatters.
    """

    speed_rpm: Real
    depth_m: Real

    def chance(self, depth_m: Real | float) -> Real:
        """Return the chance of chatter at one depth or a depth per speed, (n_speeds,)."""
        return np.asarray(np.mean(self.depth_m <= depth_m, axis=0))

    def quantile(self, share: float) -> Real:
        """Return the depth that chatters in a share of the samples, (n_speeds,) [m]."""
        return np.asarray(np.quantile(self.depth_m, share, axis=0, method='inverted_cdf'))


def is_uncertain(modes: ToolModes, cut: Cut) -> bool:
    """Tell whether anything is known of how sure the limits are."""
    return modes.covariance is not None or cut.coefficients.relative_std > 0.0


def sampled_tools(
    modes: ToolModes, cut: Cut, n_samples: int, rng: np.random.Generator
) -> list[tuple[ToolModes, Cut]]:
    """Return samples of the tool's modes with samples of the cut.

    Raises
    ------
    SettingsError
        The covariance is none, or nothing at all is known to be uncertain.
    """
    if not is_uncertain(modes, cut):
        raise SettingsError('neither modes nor cutting coefficients have a σ')
    off = np.zeros((n_samples, modes.parameters.size))
    if modes.covariance is not None:
        values, vectors = np.linalg.eigh(modes.covariance)
        if values.min() < -1e-6 * max(values.max(), 0.0):
            raise SettingsError('the covariance of the modes is none: it has negative variances')
        wide = vectors * np.sqrt(np.maximum(values, 0.0))
        off = rng.standard_normal(off.shape) @ wide.T
    factor = np.exp(cut.coefficients.relative_std * rng.standard_normal(n_samples))
    return [
        (modes.with_parameters(modes.parameters + step), scaled(cut, float(size)))
        for step, size in zip(off, factor, strict=True)
    ]


def scaled(cut: Cut, factor: float) -> Cut:
    """Return the cut in a material whose cutting coefficients are so many times as large."""
    cutting = (factor * value for value in cut.coefficients.cutting_pa)
    names = ('tangential_pa', 'radial_pa', 'axial_pa')
    changed = dict(zip(names, cutting, strict=True))
    return replace(cut, coefficients=replace(cut.coefficients, **changed))


def sampled_limits(
    modes: ToolModes, cut: Cut, limits_of: LimitsOf, n_samples: int, rng: np.random.Generator
) -> LimitSample:
    """Return limits of samples; each sample is the same at all speeds.

    Parameters
    ----------
    modes : ToolModes
        With their covariance, in the axes of the cut.
    cut : Cut
    limits_of : callable
        Limits of modes in a cut, at the speeds wanted.
    n_samples : int
    rng : Generator
    """
    found = [limits_of(*each) for each in sampled_tools(modes, cut, n_samples, rng)]
    return LimitSample(found[0].speed_rpm, np.array([each.depth_m for each in found]))


def linear_std(modes: ToolModes, cut: Cut, limits_of: LimitsOf) -> Real:
    """Return the standard deviation of the log of the limit, by straight lines, (n_speeds,).

    Parameters
    ----------
    modes : ToolModes
        With their covariance, in the axes of the cut.
    cut : Cut
    limits_of : callable
        Limits of modes in a cut, at the speeds wanted.
    """
    variance: Real = np.full(limits_of(modes, cut).depth_m.shape, cut.coefficients.relative_std**2)
    if modes.covariance is None:
        return np.sqrt(variance)
    values, vectors = np.linalg.eigh(modes.covariance)
    for value, vector in zip(values, vectors.T, strict=True):
        if value <= 0.0:
            continue
        step = STEP * math.sqrt(value) * vector
        both = [
            np.log(limits_of(modes.with_parameters(modes.parameters + way), cut).depth_m)
            for way in (step, -step)
        ]
        with np.errstate(invalid='ignore'):
            slope = (both[0] - both[1]) / (2.0 * STEP)
        variance = variance + slope**2
    return np.sqrt(variance)
