"""Covariance of rows: each is a linear function of unknown functions of the pose.

A part p of the unknowns has independent members, each with the covariance c_p² + v_p² k(q, q'),
so that rows a and b have a·b (c_p² + v_p² k).  k is a Matérn kernel of order 5/2 over the
chords of the joint angles, that is on their sines and cosines: a full turn changes nothing.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from workspace_map.regression.scales import Scales

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Rows:
    """Linear rows at poses.

    Parameters
    ----------
    parts : tuple of (n_rows, n_members) array
        Derivative of each row with respect to the members of each part of the unknowns.
    q : (n_poses, n_joints) array [rad]
        Poses.
    pose : (n_rows,) int array
        Which of them each row is at.
    kind : (n_rows,) int array
        Which white part each row has.
    """

    parts: tuple[Array, ...]
    q: Array
    pose: NDArray[np.intp]
    kind: NDArray[np.intp]

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.pose)


def chords(first: Array, second: Array) -> Array:
    """Return (2 sin Δ/2)² = 2 (1 - cos Δ) per joint, (n_joints, n_first, n_second)."""
    apart = first.T[:, :, None] - second.T[:, None, :]
    return np.asarray(2.0 * (1.0 - np.cos(apart)))


def likeness(first: Array, second: Array, length: Array) -> Array:
    """Return k of each pose with each, (n_first, n_second); Matérn 5/2, 1 at the same pose."""
    distance = np.sqrt(5.0 * np.tensordot(length**-2.0, chords(first, second), 1))
    return np.asarray((1.0 + distance + distance**2 / 3.0) * np.exp(-distance))


def likeness_slopes(q: Array, length: Array) -> Array:
    """Return the derivative of k per log length, (n_joints, n_poses, n_poses)."""
    apart = chords(q, q) / length[:, None, None] ** 2
    distance = np.sqrt(5.0 * apart.sum(axis=0))
    return np.asarray(5.0 / 3.0 * (1.0 + distance) * np.exp(-distance) * apart)


def covariance(first: Rows, second: Rows, scales: Scales) -> Array:
    """Return the prior covariance of rows without their white parts, (n_first, n_second)."""
    k = likeness(first.q, second.q, scales.length)[first.pose[:, None], second.pose]
    found = np.zeros((len(first), len(second)))
    varying = np.zeros_like(found)
    for part, (a, b) in enumerate(zip(first.parts, second.parts, strict=True)):
        gram = a @ b.T
        found += scales.constant[part] ** 2 * gram
        if scales.varying[part] > 0.0:
            varying += scales.varying[part] ** 2 * gram
    return np.asarray(found + varying * k)


def variance(rows: Rows, scales: Scales) -> Array:
    """Return the diagonal of `covariance` of rows with themselves, (n_rows,)."""
    squares = scales.constant**2 + scales.varying**2
    own = (np.sum(part**2, axis=1) for part in rows.parts)
    return np.asarray(sum(square * size for square, size in zip(squares, own, strict=True)))
