"""Values of several set-ups as one, when the set-ups may differ by more than chance.

Between set-ups the temperature, the force and the mass of the sensors change: all modes of a
set-up shift together, and each for itself.  How much is not known beforehand, and few set-ups
tell little of it; what they tell is a distribution of both scatters, over which the answer is
averaged.  Where the scatter is below the stated deviations it adds next to nothing.

References
----------
Higgins, Thompson and Spiegelhalter (2009), doi:10.1111/j.1467-985X.2008.00552.x (random effects,
Bayesian); Patterson and Thompson (1971), doi:10.1093/biomet/58.3.545 (restricted likelihood).
"""

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from oma_identifier.compare.thresholds import COMPARISON

N_SCATTERS = 16
"""Of each kind that are tried: with 64 the values of 300 random tables moved by 2e-9 deviations at
most, the deviations by 0.7 % in half of them and by 9 % at most."""
TWO_SIGMA = 0.97725
"""Normal probability below two standard deviations."""
N_HALVINGS = 40
"""Of 16 deviations: to 1e-11 of one."""
TINY = 1e-12

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class CommonValues:
    """What the set-ups have in common.

    Parameters
    ----------
    value : (n_modes,) array
        Medians over what is known of the scatter.
    std : (n_modes,) array
        Half the half-width that holds 95.45 %, as two standard deviations do.
    scatter : float
        Between set-ups, both kinds together: the median of what is known of it.
    """

    value: Array
    std: Array
    scatter: float


def common_values(values: Array, deviations: Array, largest: float) -> CommonValues:
    """Return the values common to set-ups that scatter.

    Parameters
    ----------
    values, deviations : (n_modes, n_setups) array
        Estimates as shares of something, and their stated deviations; NaN where a set-up has
        none.
    largest : float
        Scatter that is thought possible.
    """
    seen = np.isfinite(values) & np.isfinite(deviations)
    place = np.nonzero(seen)
    y, own = values[place], deviations[place] ** 2
    if not np.any(seen.sum(axis=1) > 1):
        # Nothing tells of a scatter.
        return _single(values, deviations, seen)
    typical = math.sqrt(float(np.median(own)))
    scatter = np.geomspace(COMPARISON.least_scatter * min(typical, largest), largest, N_SCATTERS)
    together, apart = (grid.ravel() for grid in np.meshgrid(scatter, scatter))
    fits = [
        _fit(y, own + single**2, shared, place, seen.shape)
        for shared, single in zip(together, apart, strict=True)
    ]
    log_odds = np.array([fit[2] for fit in fits])
    weight = np.exp(log_odds - log_odds.max())
    weight /= weight.sum()
    mean, variance = np.array([fit[0] for fit in fits]), np.array([fit[1] for fit in fits])
    variance = np.where(seen.any(axis=1), variance, np.nan)
    std = np.sqrt(variance)
    low, middle, high = (_quantile(mean, std, weight, p) for p in (1 - TWO_SIGMA, 0.5, TWO_SIGMA))
    size = np.hypot(together, apart)
    order = np.argsort(size)
    median = int(np.searchsorted(np.cumsum(weight[order]), 0.5))
    return CommonValues(middle, 0.25 * (high - low), float(size[order][median]))


def common_positive(
    values: Array, deviations: Array, power: float, largest: float
) -> CommonValues:
    """Return the common values of numbers above zero, compared in a power of them.

    Parameters
    ----------
    values, deviations : (n_modes, n_setups) array
        Estimates and their stated deviations; NaN where there is none.
    power : float
        In which their scatter does not depend on their size.
    largest : float
        Scatter that is thought possible, as a share.

    Returns
    -------
    CommonValues
        Means, with deviations of NaN, of modes of which no deviation is stated.
    """
    typical = np.maximum(np.nanmedian(values, axis=1), TINY)
    share = np.maximum(values, TINY) / typical[:, None]
    own = np.where(deviations > 0.0, deviations, np.nan) / typical[:, None]
    found = common_values((share**power - 1.0) / power, own * share ** (power - 1.0), largest)
    factor = np.maximum(1.0 + power * found.value, 0.0) ** (1.0 / power)
    stated = np.isfinite(found.std)
    return CommonValues(
        np.where(stated, factor * typical, np.nanmean(values, axis=1)),
        np.where(stated, found.std * factor ** (1.0 - power) * typical, np.nan),
        found.scatter,
    )


def _single(values: Array, deviations: Array, seen: NDArray[np.bool_]) -> CommonValues:
    return CommonValues(
        np.where(seen, values, 0.0).sum(axis=1) + np.where(seen.any(axis=1), 0.0, np.nan),
        np.where(seen, deviations, 0.0).sum(axis=1) + np.where(seen.any(axis=1), 0.0, np.nan),
        0.0,
    )


def _fit(
    y: Array,
    variance: Array,
    shared: float,
    place: tuple[NDArray[np.intp], ...],
    size: tuple[int, ...],
) -> tuple[Array, Array, float]:
    """Return means and variances of the modes and the log likelihood, for given scatters.

    Unknown are the modes' values, of which nothing is known, and the shift of each set-up.
    """
    n_modes, n_setups = size
    rows, columns = place
    design = np.zeros((len(y), n_modes + n_setups))
    design[np.arange(len(y)), rows] = 1.0
    design[np.arange(len(y)), n_modes + columns] = 1.0
    weighted = design / variance[:, None]
    normal = design.T @ weighted
    # A mode nobody saw keeps the matrix regular and says nothing.
    blind = np.diag(normal) == 0.0
    normal[n_modes:, n_modes:] += np.eye(n_setups) / shared**2
    normal[:n_modes, :n_modes] += np.diag(blind[:n_modes].astype(float))
    inverse = np.linalg.inv(normal)
    right = weighted.T @ y
    solution = inverse @ right
    misfit = float(y @ (y / variance) - right @ solution)
    log_size = float(np.log(variance).sum() + 2.0 * n_setups * math.log(shared))
    log_likelihood = -0.5 * (misfit + log_size + np.linalg.slogdet(normal)[1])
    return solution[:n_modes], np.diag(inverse)[:n_modes].copy(), log_likelihood


def _quantile(mean: Array, std: Array, weight: Array, probability: float) -> Array:
    """Return the quantile of mixtures of normal distributions, (n_modes,) array."""
    low, high = (mean - 8.0 * std).min(axis=0), (mean + 8.0 * std).max(axis=0)
    for _ in range(N_HALVINGS):
        middle = 0.5 * (low + high)
        below = weight @ ndtr((middle - mean) / std) < probability
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return np.asarray(0.5 * (low + high))
