"""Modes that are not distinguishable: those whose half-power bands touch are one subspace.

Within it a hair of stiffness decides how the shapes are mixed; the subspace itself is as smooth
over the poses as any other mode.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from workspace_map.arm import LocalModes

Array = NDArray[np.float64]


def subspaces(frequency_hz: Array, damping_ratio: Array) -> NDArray[np.intp]:
    """Return the number of the subspace of each mode, (n_modes,), rising.

    Parameters
    ----------
    frequency_hz : (n_modes,) array [Hz]
        Rising.
    damping_ratio : (n_modes,) array
        Half of a half-power band is ζf wide.
    """
    half = damping_ratio * frequency_hz
    apart = np.diff(frequency_hz) > half[1:] + half[:-1]
    return np.concatenate([[0], np.cumsum(apart)])[: len(half)].astype(np.intp)


def members(modes: LocalModes) -> list[NDArray[np.intp]]:
    """Return the modes of interest, one array per subspace."""
    number = subspaces(modes.frequency_hz, modes.damping_ratio)
    return [np.flatnonzero(number == each) for each in np.unique(number)]


def nearest_rotation(matrix: Array) -> Array:
    """Return the matrix with orthonormal columns that is nearest (polar decomposition)."""
    left, _, right = np.linalg.svd(matrix, full_matrices=False)
    return np.asarray(left @ right)


@dataclass(frozen=True)
class Aligned:
    """Measured shapes turned, within each subspace, to what is expected there.

    Parameters
    ----------
    shapes : (n_channels, n_pairs) array
        Of unit length but for what the turn changes; a mode by itself keeps its shape but for
        the sign.
    turn : (n_pairs, n_pairs) array
        Rotation that makes expected shapes the measured ones, sign and all.
    """

    shapes: Array
    turn: Array


def aligned(shapes: Array, modes: LocalModes, expected: NDArray[np.intp]) -> Aligned:
    """Turn measured shapes to expected ones.

    Parameters
    ----------
    shapes : (n_channels, n_pairs) array
        Measured, of unit length.
    modes : LocalModes
        Expected.
    expected : (n_pairs,) int array
        Which of them each measured one is.
    """
    found, turn = shapes.copy(), np.eye(len(expected))
    size = np.linalg.norm(modes.channel_shapes, axis=0)
    for own in members(modes):
        pairs = np.flatnonzero(np.isin(expected, own))
        if not len(pairs):
            continue
        here = expected[pairs]
        scaled = shapes[:, pairs] * size[here]
        mixed = np.linalg.lstsq(modes.channel_shapes[:, here], scaled, rcond=None)[0]
        rotation = nearest_rotation(mixed)
        found[:, pairs] = scaled @ rotation.T / size[here]
        turn[np.ix_(pairs, pairs)] = rotation
    return Aligned(found, turn)
