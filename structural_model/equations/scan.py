"""Modes over many poses at once."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from modal_core.channel import Channel
from modal_core.errors import ModelError
from structural_model.description import check_length, RobotLimits
from structural_model.equations.dynamics import Dynamics
from structural_model.equations.linearise import sensor_rows

Array = NDArray[np.float64]


@dataclass(frozen=True)
class WorkspaceScan:
    """Undamped modes at many poses, sorted by frequency at each.

    Parameters
    ----------
    q : (n_poses, n_joints) array [rad]
        Serial joint angles.
    frequency_hz, damping_ratio : (n_poses, n_modes) array [Hz], [-]
        As ``ModelModes``.
    channel_shapes : (n_poses, n_channels, n_modes) array
        Mass-normalised shapes at the channels.
    """

    q: Array
    frequency_hz: Array
    damping_ratio: Array
    channel_shapes: Array


def scan(
    dynamics: Dynamics, q: ArrayLike, channels: Sequence[Channel] = (), n_modes: int | None = None
) -> WorkspaceScan:
    """Solve K φ = ω² M φ at every pose, in one stacked eigenproblem.

    Parameters
    ----------
    dynamics : Dynamics
        The arm.
    q : (n_poses, n_joints) array [rad]
        Serial joint angles.
    channels : sequence of Channel
        Where shapes are wanted.
    n_modes : int, optional
        Keep the lowest.

    Raises
    ------
    ModelError
        M or K is not positive definite at a pose.
    """
    poses = np.atleast_2d(check_length(q, dynamics.joint_names))
    size, keep = dynamics.n_dof, dynamics.n_dof if n_modes is None else n_modes
    M, C, K = (np.empty((len(poses), size, size)) for _ in range(3))
    rows = np.empty((len(poses), len(channels), size))
    for number, pose in enumerate(poses):
        found = dynamics.matrices(pose)
        M[number], C[number], K[number] = found.M, found.C, found.K
        rows[number] = sensor_rows(dynamics, pose, channels)[:, :size]
    try:
        inverse = np.linalg.inv(np.linalg.cholesky(M))
    except np.linalg.LinAlgError as error:
        raise ModelError('mass matrix is not positive definite at a pose') from error
    squared, turned = np.linalg.eigh(inverse @ K @ inverse.transpose(0, 2, 1))
    if (squared[:, 0] <= 0.0).any():
        pose = int(np.argmin(squared[:, 0]))
        raise ModelError('stiffness matrix is not positive definite', found=poses[pose].tolist())
    shapes = (inverse.transpose(0, 2, 1) @ turned)[:, :, :keep]
    omega = np.sqrt(squared[:, :keep])
    modal_damping = np.einsum('pim,pim->pm', shapes, C @ shapes)
    return WorkspaceScan(
        q=poses,
        frequency_hz=omega / (2.0 * np.pi),
        damping_ratio=modal_damping / (2.0 * omega),
        channel_shapes=rows @ shapes,
    )


def random_poses(limits: RobotLimits, count: int, rng: np.random.Generator) -> Array:
    """Return poses drawn evenly over the axis ranges, inside the coupled ranges too.

    Parameters
    ----------
    limits : RobotLimits
        Ranges; an endless axis is drawn over one turn.
    count : int
        How many.
    rng : numpy.random.Generator
        Source of the draw.

    Returns
    -------
    (count, n_joints) array [rad]
        Serial joint angles.
    """
    low = np.where(np.isfinite(limits.controller_low), limits.controller_low, -np.pi)
    high = np.where(np.isfinite(limits.controller_high), limits.controller_high, np.pi)
    found: list[Array] = []
    for _ in range(1000 * count):
        q = limits.axes.to_serial(rng.uniform(low, high))
        if limits.position_violation(q) is None:
            found.append(q)
        if len(found) == count:
            return np.array(found)
    raise ModelError('ranges leave hardly any pose', found=f'{len(found)} of {count}')
