"""Measured modes of all poses as linear rows about the present state of each pose."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from workspace_map.arm import (
    Arm,
    damping_slopes,
    frequency_slopes,
    LocalModes,
    shape_slopes,
    Slopes,
)
from workspace_map.measured_pose import MeasuredPose
from workspace_map.prior import damping_parts, FREQUENCY, SHAPE, structure_parts
from workspace_map.regression import Rows

Array = NDArray[np.float64]
Pairs = tuple[NDArray[np.intp], NDArray[np.intp]]


@dataclass(frozen=True)
class Block:
    """Rows of one pose: what they depend on, what was measured less what is expected, and σ.

    Parameters
    ----------
    parts : tuple of (n_rows, n_members) array
        Derivatives.
    residual, std : (n_rows,) array
        Measured less expected, and the standard deviation of the measurement.
    kind : (n_rows,) int array
        `FREQUENCY` or `SHAPE`.
    """

    parts: tuple[Array, ...]
    residual: Array
    std: Array
    kind: NDArray[np.intp]


def stacked_slopes(*slopes: Slopes) -> Slopes:
    """Return all rows of several derivatives, one after the other."""
    return Slopes(
        *(
            np.vstack([getattr(each, name) for each in slopes])
            for name in ('spring', 'coupling', 'mass')
        )
    )


def shape_of(modes: LocalModes, near: NDArray[np.intp]) -> Array:
    """Return the change of a shape of unit length at some channels, per shape at all of them.

    Returns
    -------
    (n_modes, n_near, n_channels) array
    """
    shapes = modes.channel_shapes
    size = np.linalg.norm(shapes, axis=0)
    unit = (shapes / size).T
    picked = np.eye(len(shapes))[near]
    return np.asarray((picked - unit[:, near, None] * unit[:, None, :]) / size[:, None, None])


def damping_structure(modes: LocalModes) -> Slopes:
    """Return the derivatives of log ζ = log φᵀCφ - log 2ω with respect to the structure."""
    pulled = modes.damping @ modes.shapes[:, : modes.n]
    whole = np.sum(modes.shapes[:, : modes.n] * pulled, axis=0)
    of = (2.0 * pulled / whole).T[:, None, :]
    turned = shape_slopes(modes, of, np.eye(len(modes.squared)))
    higher = frequency_slopes(modes)
    return Slopes(
        turned.spring - higher.spring,
        turned.coupling - higher.coupling,
        turned.mass - higher.mass,
    )


def structure_block(
    arm: Arm, modes: LocalModes, measured: MeasuredPose, pairs: Pairs, near: NDArray[np.intp]
) -> Block:
    """Return rows of log f and of the shape near the tool, relative to the whole shape.

    Parameters
    ----------
    arm : Arm
        The arm.
    modes : LocalModes
        Expected at the pose.
    measured : MeasuredPose
        Found there.
    pairs : tuple of two int arrays
        Measured modes and which of the expected they are.
    near : (n_near,) int array
        Channels near the tool.
    """
    found, expected = pairs
    shapes = modes.channel_shapes
    unit = shapes / np.linalg.norm(shapes, axis=0)
    shape = shape_slopes(modes, shape_of(modes, near), modes.arm.channels)
    slopes = stacked_slopes(frequency_slopes(modes), shape)
    n_near = len(near)
    take = np.concatenate(
        [expected, modes.n + (expected[:, None] * n_near + np.arange(n_near)).ravel()]
    )
    sign = np.sign(np.sum(measured.shapes[:, found] * unit[:, expected], axis=0))
    off = sign * measured.shapes[:, found] - unit[:, expected]
    relative = measured.frequency_std_hz[found] / measured.frequency_hz[found]
    higher = np.log(measured.frequency_hz[found] / modes.frequency_hz[expected])
    std = np.concatenate([relative, measured.shape_std[np.ix_(near, found)].T.ravel()])
    known = np.isfinite(std)
    return Block(
        parts=tuple(part[take[known]] for part in structure_parts(arm, slopes)),
        residual=np.concatenate([higher, off[near].T.ravel()])[known],
        std=std[known],
        kind=np.repeat([FREQUENCY, SHAPE], [len(found), n_near * len(found)])[known],
    )


def damping_block(arm: Arm, modes: LocalModes, measured: MeasuredPose, pairs: Pairs) -> Block:
    """Return rows of log ζ of the modes whose damping is known."""
    found, expected = pairs
    known = np.isfinite(measured.damping_ratio_std[found]) & (measured.damping_ratio[found] > 0.0)
    found, expected = found[known], expected[known]
    ratio = measured.damping_ratio[found]
    return Block(
        parts=tuple(part[expected] for part in damping_parts(arm, damping_slopes(modes))),
        residual=np.log(ratio / modes.damping_ratio[expected]),
        std=measured.damping_ratio_std[found] / ratio,
        kind=np.zeros(len(found), dtype=np.intp),
    )


def stacked(blocks: Sequence[Block], q: Array) -> tuple[Rows, Array, Array]:
    """Return the rows of all poses, their residuals and standard deviations.

    Parameters
    ----------
    blocks : sequence of Block
        One per pose, at least one.
    q : (n_poses, n_joints) array [rad]
        The poses.
    """
    pose = np.repeat(np.arange(len(blocks)), [len(block.residual) for block in blocks])
    parts = tuple(np.vstack(each) for each in zip(*(block.parts for block in blocks), strict=True))
    kind = np.concatenate([block.kind for block in blocks])
    residual = np.concatenate([block.residual for block in blocks])
    return Rows(parts, q, pose, kind), residual, np.concatenate([block.std for block in blocks])
