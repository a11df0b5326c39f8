"""First shapes, from amplitudes that every FRF has of its own."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from impact_testing.fit.free_fit import FreePoint
from impact_testing.fit.places import Places

Complex = NDArray[np.complex128]
STEPS = 10
"""Each solves for every place with the others given; what is left the likelihood does."""


def first_shapes(free: Sequence[FreePoint], places: Places) -> Complex:
    """Return shapes whose products come near the amplitudes, (n_poles, n_places) array."""
    table = np.zeros((len(free[0].amplitude), places.n, places.n), dtype=complex)
    for point, into, out in zip(free, places.into, places.out, strict=True):
        table[:, out, into] = point.amplitude
    return np.array([_shape(each, places) for each in table]).reshape(-1, places.n)


def _shape(table: Complex, places: Places) -> Complex:
    """Return the shape whose products come near the entries of a table that were measured."""
    tied = table != 0.0
    value = np.where(tied.T & ~tied, table.T, table)
    tied = tied | tied.T
    shape = _first_guess(value, tied, places)
    for _ in range(STEPS):
        seen = np.where(tied, value, 0.0) @ shape.conj()
        power = tied @ np.abs(shape) ** 2
        # Half-way: where all places move at once the whole step swings from side to side.
        shape = 0.5 * (shape + np.divide(seen, power, out=shape.copy(), where=power > 0.0))
    return np.asarray(shape)


def _first_guess(value: Complex, tied: NDArray[np.bool_], places: Places) -> Complex:
    """Return a shape by the strongest entry and all that share its point or its channel."""
    shape = np.zeros(places.n, dtype=complex)
    if places.tied:
        start = int(np.argmax(np.abs(np.diag(value))))
        shape[start] = np.sqrt(value[start, start] + 0j)
    else:
        start = places.into[int(np.argmax(np.abs(value[:, list(places.into)]).max(axis=0)))]
        shape[start] = np.sqrt(np.abs(value[:, start]).max())
    known = shape != 0.0
    for _ in range(places.n):
        power = (tied & known[None]) @ np.abs(shape) ** 2
        fresh = ~known & (power > 0.0)
        if not fresh.any():
            break
        seen = np.where(tied & known[None], value, 0.0) @ shape.conj()
        shape[fresh] = seen[fresh] / power[fresh]
        known |= fresh
    return shape
