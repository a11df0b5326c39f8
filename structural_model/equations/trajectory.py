"""Response along a trajectory that changes the pose: matrices and loads follow the motion."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from modal_core.channel import Channel
from modal_core.errors import ModelError
from modal_core.units import ANGULAR_VELOCITY
from structural_model.description import check_length
from structural_model.equations.dynamics import Dynamics
from structural_model.equations.linearise import gravity_rows, sensor_rows
from structural_model.equations.response import held_system, TimeResponse

Array = NDArray[np.float64]


def follow(
    dynamics: Dynamics,
    motion: Sequence[ArrayLike],
    channels: Sequence[Channel],
    sample_rate_hz: float,
    pose_step_rad: float,
) -> TimeResponse:
    """Return deflection and its readings; see ``FlexibleJointModel.trajectory_response``.

    The matrices are held while no joint has moved by more than ``pose_step_rad``, the load of the
    rigid motion is linear between samples, and each held system is integrated exactly.

    Returns
    -------
    TimeResponse
        Output: the flexible part of the readings only.
    """
    q, qd, qdd = (np.atleast_2d(check_length(part, dynamics.joint_names)) for part in motion)
    if not (q.shape == qd.shape == qdd.shape):
        raise ModelError('motion of unequal length', found=(q.shape, qd.shape, qdd.shape))
    if not (sample_rate_hz > 0.0 and pose_step_rad > 0.0):
        raise ModelError('rate and pose step are positive', found=(sample_rate_hz, pose_step_rad))
    force = dynamics.rigid_force(q, qd, qdd)
    size = dynamics.n_dof
    state = np.zeros((len(q), 2 * size))
    output = np.zeros((len(q), len(channels)))
    state[0, :size] = dynamics.static_deflection(q[0])
    for start, end in _held_stretches(q, pose_step_rad):
        _stretch(dynamics, q[start], force, channels, sample_rate_hz, (start, end), state, output)
    return TimeResponse(output=output, state=state)


def _held_stretches(q: Array, step: float) -> list[tuple[int, int]]:
    borders, last = [0], q[0]
    for sample, pose in enumerate(q):
        if np.abs(pose - last).max() > step:
            borders.append(sample)
            last = pose
    return list(zip(borders, [*borders[1:], len(q)], strict=True))


def _stretch(
    dynamics: Dynamics,
    pose: Array,
    force: Array,
    channels: Sequence[Channel],
    rate: float,
    span: tuple[int, int],
    state: Array,
    output: Array,
) -> None:
    """Integrate one stretch in place; the load's own change of stiffness is in K already."""
    start, end = span
    size = dynamics.n_dof
    matrices = dynamics.matrices(pose)
    solved = np.linalg.solve(matrices.M, np.hstack([-matrices.K, -matrices.C, np.eye(size)]))
    A = np.vstack([np.eye(2 * size)[size:], solved[:, : 2 * size]])
    B = np.vstack([np.zeros((size, size)), solved[:, 2 * size :]])
    held = held_system(A, B, 1.0 / rate)
    last = min(end, len(state) - 1)
    step = np.diff(force[start : last + 1], axis=0)
    drive = force[start:last] @ held.now.T + step @ held.change.T
    for sample in range(start, last):
        state[sample + 1] = held.transition @ state[sample] + drive[sample - start]
    motion = sensor_rows(dynamics, pose, channels)[:, :size]
    tilt = gravity_rows(dynamics, pose, channels)[:, :size]
    here = state[start:end]
    acceleration = here @ solved[:, : 2 * size].T + force[start:end] @ solved[:, 2 * size :].T
    output[start:end] = acceleration @ motion.T + here[:, :size] @ tilt.T
    gyro = [channel.unit == ANGULAR_VELOCITY for channel in channels]
    output[start:end, gyro] = here[:, size:] @ motion[gyro].T
