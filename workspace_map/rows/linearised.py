"""Measured modes of all poses as linear rows about the present state of each pose."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

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
from workspace_map.rows.principal_rows import flat, principal_rows
from workspace_map.rows.subspace import aligned

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


def structure_block(arm: Arm, modes: LocalModes, measured: MeasuredPose, pairs: Pairs) -> Block:
    """Return rows of log f and of the whole shape where it tells most.

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
    """
    found, expected = pairs
    modes = replace(modes, n=int(np.max(expected, initial=-1)) + 1)
    principal = principal_rows(arm, modes)
    shapes = aligned(measured.shapes[:, found], modes, expected).shapes
    turn = principal.turn[expected]
    off = np.einsum('rkc,cr->rk', turn, shapes)
    spread = np.sqrt(np.einsum('rkc,cr->rk', turn**2, measured.shape_std[:, found] ** 2))
    relative = measured.frequency_std_hz[found] / measured.frequency_hz[found]
    higher = np.log(measured.frequency_hz[found] / modes.frequency_hz[expected])
    std = np.concatenate([relative, spread.ravel()])
    known = np.isfinite(std)
    own = structure_parts(arm, frequency_slopes(modes))
    each = zip(own, principal.parts, strict=True)
    parts = (np.vstack([a[expected], flat(b[expected])]) for a, b in each)
    return Block(
        parts=tuple(part[known] for part in parts),
        residual=np.concatenate([higher, off.ravel()])[known],
        std=std[known],
        kind=np.repeat([FREQUENCY, SHAPE], [len(found), off.size])[known],
    )


def damping_block(arm: Arm, modes: LocalModes, measured: MeasuredPose, pairs: Pairs) -> Block:
    """Return rows of ζ over what is expected, of the modes whose damping is known.

    Not of log ζ: its deviation would be over the measured ζ, so that of two measurements the one
    that came out higher would count for more. At 25 % that alone makes ζ 9 % too high.
    """
    found, expected = pairs
    known = np.isfinite(measured.damping_ratio[found] + measured.damping_ratio_std[found])
    found, expected = found[known], expected[known]
    there = modes.damping_ratio[expected]
    return Block(
        parts=tuple(part[expected] for part in damping_parts(arm, damping_slopes(modes))),
        residual=measured.damping_ratio[found] / there - 1.0,
        std=measured.damping_ratio_std[found] / there,
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
