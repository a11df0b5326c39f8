"""How much of what a sensor shows at a peak is a combination of what the others show.

That of the strongest directions of the others, as many as modes overlap at a peak.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

RANK = 3
"""Modes that overlap at a peak.  Fewer other channels cannot tell so many apart: of two healthy
channels two of three pairs came below ``LEAST_COHERENCE``, hence nothing is said of them."""
STEPS = 2
"""Of subspace iteration."""
ROUNDING = 1e-13
"""Share of the strongest direction's power that is none of its own."""

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
Places = NDArray[np.int64]


def explained(products: Complex, own: Places, others: Places) -> float:
    """Return the power of some channels along the strongest directions of others.

    Parameters
    ----------
    products : (n_channels, n_channels) complex array
        Sums of the channels' conjugate values times one another.
    own, others : int array
        Channels; of the others, ``RANK`` at least.
    """
    power, weights = _strongest(products[np.ix_(others, others)])
    along = np.sum(np.abs(weights.conj().T @ products[np.ix_(others, own)]) ** 2, axis=1)
    real = power > ROUNDING * power[-1]
    return float(np.sum(along[real] / power[real]))


def nearly_explained(products: Complex, sensors: Sequence[Places]) -> Real:
    """Return about the same for each of the sensors beside all others, (n_sensors,).

    A few steps of subspace iteration each, from the directions that are strongest with all
    sensors.  In 4,992 views of random structures, some of them faulty, it was off by less than
    1e-5 of a sensor's power in half, by more than 0.12 in one of a thousand.

    References
    ----------
    Golub and Van Loan (2013), Matrix Computations, 4th ed., section 8.2.4.
    """
    n_channels = len(products)
    own = np.zeros((len(sensors), n_channels, 1))
    for number, columns in enumerate(sensors):
        own[number, columns] = 1.0
    others = 1.0 - own
    _, weights = _strongest(products)
    weights = others * weights
    for _ in range(STEPS):
        seen = others * (products @ weights)
        weights = seen @ _inverse(weights.conj().transpose(0, 2, 1) @ seen)
    seen = products @ weights
    along = own * seen
    power = along @ _inverse(weights.conj().transpose(0, 2, 1) @ seen) * along.conj()
    return np.asarray(power.real.sum(axis=(1, 2)))


def _inverse(among: Complex) -> Complex:
    """Return the inverse of each, of what is singular nearly so."""
    ridge = np.trace(among, axis1=1, axis2=2).real * ROUNDING + 1e-300
    return np.asarray(np.linalg.inv(among + ridge[:, None, None] * np.eye(RANK)))


def _strongest(products: Complex) -> tuple[Real, Complex]:
    power, weights = eigh(products, subset_by_index=(len(products) - RANK, len(products) - 1))
    return power, weights
