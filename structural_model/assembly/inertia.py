"""Inertias in link axes: shares, points, and what is left when a beam is taken out."""

import numpy as np
from numpy.typing import NDArray
import pinocchio as pin

from modal_core.errors import ModelError

Matrix = NDArray[np.float64]


def scaled(inertia: pin.Inertia, share: float) -> pin.Inertia:
    """Return a share of an inertia."""
    return pin.Inertia(inertia.mass * share, inertia.lever, inertia.inertia * share)


def point_mass(mass: float, place: Matrix) -> pin.Inertia:
    """Return a point mass [kg] at a place (3,) [m]."""
    return pin.Inertia(mass, place, np.zeros((3, 3)))


def without(inertia: pin.Inertia, rod: pin.Inertia, where: str) -> pin.Inertia:
    """Take a beam out of a link's inertia, so that the whole stays what the URDF says."""
    left = inertia.mass - rod.mass
    total = _at_origin(inertia)
    if left < -1e-9:
        raise ModelError('beam heavier than its link', where=where, found=f'{rod.mass} kg')
    if left <= 1e-9 * inertia.mass:
        return pin.Inertia.Zero()
    lever = (inertia.mass * inertia.lever - rod.mass * rod.lever) / left
    rest = total - _at_origin(rod) - _steiner(left, lever)
    if np.linalg.eigvalsh(rest)[0] < -1e-6 * np.trace(total):
        raise ModelError(
            'beam takes more inertia than its link has',
            where=where,
            found=f'{rod.mass} kg',
            advice='spread less of the link along the beam',
        )
    return pin.Inertia(left, lever, rest)


def _at_origin(inertia: pin.Inertia) -> Matrix:
    return np.asarray(inertia.inertia + _steiner(inertia.mass, inertia.lever))


def _steiner(mass: float, lever: Matrix) -> Matrix:
    return np.asarray(mass * (lever @ lever * np.eye(3) - np.outer(lever, lever)))
