"""What shapes tell of the arm, in few rows: the directions in which they may depart farthest.

A shape has as many entries as there are channels, and what an arm may have moves it in few
directions. These are the principal ones of its prior covariance; noise stays what it is, because
they are orthonormal.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from workspace_map.arm import Arm, LocalModes, shape_slopes
from workspace_map.prior import structure_parts, structure_scales
from workspace_map.rows.subspace import members

Array = NDArray[np.float64]
ROWS = 4
"""Per mode."""


@dataclass(frozen=True)
class PrincipalRows:
    """Rows of shapes of unit length.

    Parameters
    ----------
    turn : (n_modes, n_rows, n_channels) array
        Orthonormal directions; none is in the subspace of the mode itself.
    parts : tuple of (n_modes, n_rows, n_members) array
        Derivatives of what a shape has along them.
    """

    turn: Array
    parts: tuple[Array, ...]


def flat(part: Array) -> Array:
    """Return the rows of all modes one after the other, (n_modes n_rows, n_members).

    An arm may have no members of a part: springs of the base, of bearings.
    """
    n_modes, n_rows, n_members = part.shape
    return part.reshape(n_modes * n_rows, n_members)


def principal_rows(arm: Arm, modes: LocalModes) -> PrincipalRows:
    """Return the rows of the modes of interest."""
    n, count = modes.n, len(modes.arm.channels)
    slopes = shape_slopes(modes, _beyond_subspace(modes), modes.arm.channels)
    parts = [part.reshape(n, count, part.shape[-1]) for part in structure_parts(arm, slopes)]
    scales = structure_scales(arm.model.n_joints).constant
    moved = np.zeros((n, count, count))
    for scale, part in zip(scales, parts, strict=True):
        moved += scale**2 * part @ part.transpose(0, 2, 1)
    turn = np.linalg.eigh(moved)[1][:, :, -min(ROWS, count) :].transpose(0, 2, 1)
    return PrincipalRows(turn, tuple(turn @ part for part in parts))


def _beyond_subspace(modes: LocalModes) -> Array:
    """Return the change of a unit shape outside its subspace per shape, (n, n_ch, n_ch)."""
    shapes = modes.channel_shapes
    size = np.linalg.norm(shapes, axis=0)
    found = np.empty((modes.n, len(shapes), len(shapes)))
    for own in members(modes):
        within = np.linalg.qr(shapes[:, own])[0]
        found[own] = np.eye(len(shapes)) - within @ within.T
    return np.asarray(found / size[:, None, None])
