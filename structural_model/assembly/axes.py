"""Directions along and across axes."""

from functools import cache

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import ModelError
from structural_model.description import Vector

Matrix = NDArray[np.float64]


@cache
def across(axis: Vector) -> tuple[Matrix, Matrix]:
    """Return the two unit vectors across an axis, cyclic: z gives x and y, y gives z and x.

    Parameters
    ----------
    axis : (3,) tuple
        Need not be a unit vector.
    """
    unit = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    helper = np.zeros(3)
    helper[(int(np.argmax(np.abs(unit))) + 1) % 3] = 1.0
    first = helper - (helper @ unit) * unit
    first /= np.linalg.norm(first)
    second = np.cross(unit, first)
    first.flags.writeable = second.flags.writeable = False
    return first, second


def unit(axis: Vector, where: str) -> Matrix:
    """Return the unit vector along an axis.

    Raises
    ------
    ModelError
        It has no length.
    """
    length = float(np.linalg.norm(axis))
    if length < 1e-9:
        raise ModelError('axis is zero', where=where)
    return np.asarray(np.array(axis) / length)
