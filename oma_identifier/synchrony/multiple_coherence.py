"""How much of what a sensor shows at a peak is a linear combination of what the others show.

The others' directions are used as far as the lines of the peak can tell them apart: a ridge keeps
the effective number of coefficients to half the independent values, so that chance explains at
most half of what is not common, and the known share of it is put right.

References
----------
Bendat and Piersol (2010), Random Data, 4th ed., section 7.3 (multiple coherence); Hastie et al.
(2009), The Elements of Statistical Learning, 2nd ed., eq. 3.50 (effective degrees of freedom).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

SHARE = 0.5
"""Of the independent values, as many coefficients as may be estimated from them."""
ROUNDING = 1e-12
"""Share of the strongest direction's power that is none of its own."""
BISECTIONS = 40
"""Each halves the logarithm of the ridge's range: to less than rounding."""

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
Places = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Residual:
    """What the others do not explain of each sensor.

    Parameters
    ----------
    power : (n_sensors,) array
        In the units of the products.
    n_used : (n_sensors,) array
        Effective number of coefficients it took.
    """

    power: Real
    n_used: Real


def residual_of(products: Complex, sensors: Sequence[Places], n_free: float) -> Residual:
    """Return what is left of each sensor by its regression on all others.

    One decomposition serves all sensors: the inverse's block of a sensor is the inverse of its
    residual covariance.

    Parameters
    ----------
    products : (n_channels, n_channels) complex array
        Sums of the channels' conjugate values times one another.
    sensors : sequence of int array
        Channels of each sensor.
    n_free : float
        Independent values behind the sums.
    """
    power, directions = np.linalg.eigh(products)
    power = np.maximum(power, 0.0)
    ridge = _ridge(power, SHARE * n_free)
    inverse = (directions / (power + ridge)) @ directions.conj().T
    # Power of each column of the inverse, and its trace, tell the coefficients used.
    trace = np.trace(inverse).real
    left, used = np.empty((2, len(sensors)))
    for number, own in enumerate(sensors):
        columns = inverse[:, own]
        block = np.linalg.inv(columns[own])
        left[number] = np.trace(block).real - ridge * len(own)
        others = trace - np.trace(block @ columns.conj().T @ columns).real
        used[number] = len(products) - len(own) - ridge * others
    return Residual(np.maximum(left, 0.0), used)


def _ridge(power: Real, most: float) -> float:
    """Return the least ridge with which no more coefficients than ``most`` are used."""
    low, high = ROUNDING * power[-1] + 1e-300, power.sum() / most + 1e-300
    if _n_used(power, low) <= most:
        return float(low)
    for _ in range(BISECTIONS):
        middle = np.sqrt(low * high)
        low, high = (middle, high) if _n_used(power, middle) > most else (low, middle)
    return float(high)


def _n_used(power: Real, ridge: float) -> float:
    return float(np.sum(power / (power + ridge)))
