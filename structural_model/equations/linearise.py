"""The linear system from motor accelerations and forces to sensor readings at one pose."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray
import pinocchio as pin

from modal_core.channel import Channel
from modal_core.units import ANGULAR_VELOCITY
from structural_model.equations import sensing
from structural_model.equations.dynamics import Dynamics
from structural_model.equations.response import StateSpace

Array = NDArray[np.float64]


def sensor_rows(
    dynamics: Dynamics,
    q: ArrayLike,
    channels: Sequence[Channel],
    deflection: ArrayLike | None = None,
) -> Array:
    """Return channel motion per unit deflection, then per unit motor-side motion.

    Returns
    -------
    (n_channels, n_dof + n_joints) array
    """
    return _rows(dynamics, q, channels, sensing.jacobian_rows, deflection)


def gravity_rows(
    dynamics: Dynamics,
    q: ArrayLike,
    channels: Sequence[Channel],
    deflection: ArrayLike | None = None,
) -> Array:
    """Return change of gravity readings per unit deflection, then per unit motor-side motion.

    Returns
    -------
    (n_channels, n_dof + n_joints) array
    """
    return _rows(dynamics, q, channels, sensing.gravity_rows, deflection)


def reading_rows(
    dynamics: Dynamics,
    q: ArrayLike,
    channels: Sequence[Channel],
    deflection: ArrayLike | None = None,
) -> tuple[Array, Array]:
    """Return ``sensor_rows`` and ``gravity_rows`` at once."""
    motion = sensor_rows(dynamics, q, channels, deflection)
    return motion, _rows_there(dynamics, channels, sensing.gravity_rows)


def rest_readings(
    dynamics: Dynamics,
    q: ArrayLike,
    channels: Sequence[Channel],
    deflection: ArrayLike | None = None,
    motion: tuple[Array, Array] | None = None,
) -> Array:
    """Return what accelerometers read, d·Rᵀ(a - g), at rest -d·Rᵀg, (n_channels,) [m/s²].

    Parameters
    ----------
    dynamics : Dynamics
        Of the arm.
    q : (n_joints,) array [rad]
        The pose.
    channels : sequence of Channel
        Accelerometers.
    deflection : (n_dof,) array or None
        As the arm hangs; None: as its motors stand.
    motion : two (n_joints,) arrays [rad/s], [rad/s²] or None
        Velocity and acceleration of the motors, of a rigid motion; None: at rest.
    """
    assembly = dynamics.assembly
    full = dynamics.position(q, deflection)
    velocity, acceleration = np.zeros((2, assembly.model.nv))
    if motion is not None:
        velocity[assembly.drives], acceleration[assembly.drives] = motion
    pin.forwardKinematics(assembly.model, assembly.data, full, velocity, acceleration)
    found = sensing.sensor_map(assembly, tuple(channels))
    gravity = np.asarray(assembly.model.gravity.linear)
    readings = np.zeros(len(channels))
    for joint, members in found.groups:
        rotation = assembly.data.oMi[joint].rotation
        speed, change = assembly.data.v[joint], assembly.data.a[joint]
        carried = speed.linear + np.cross(speed.angular, found.position[members])
        turning = np.cross(speed.angular, carried) - rotation.T @ gravity
        readings[members] = found.wrench[members] @ change.vector
        readings[members] += np.einsum('ci,ci->c', found.direction[members], turning)
    return readings


def state_space(
    dynamics: Dynamics, q: ArrayLike, channels: Sequence[Channel], forces: Sequence[Channel]
) -> StateSpace:
    """Return the system; see ``FlexibleJointModel.state_space``."""
    matrices = dynamics.matrices(q)
    size, joints = dynamics.n_dof, len(dynamics.joint_names)
    half = size + joints
    pushed = sensor_rows(dynamics, q, forces)[:, :size].T
    push = np.hstack([dynamics.input_matrix(q), pushed])
    blocks = np.hstack([-matrices.K, -dynamics.gravity_coupling(q), -matrices.C, push])
    solved = np.linalg.solve(matrices.M, blocks)
    A, B = np.zeros((2 * half, 2 * half)), np.zeros((2 * half, push.shape[1]))
    A[:half, half:] = np.eye(half)
    A[half : half + size, :half] = solved[:, :half]
    A[half : half + size, half : half + size] = solved[:, half : half + size]
    B[half : half + size] = solved[:, half + size :]
    B[half + size :, :joints] = np.eye(joints)
    motion = sensor_rows(dynamics, q, channels)
    gyro = np.array([channel.unit == ANGULAR_VELOCITY for channel in channels], dtype=bool)
    C, D = motion @ A[half:], motion @ B[half:]
    C[:, :half] += gravity_rows(dynamics, q, channels)
    C[gyro] = np.hstack([np.zeros_like(motion[gyro]), motion[gyro]])
    D[gyro] = 0.0
    return StateSpace(
        A=A,
        B=B,
        C=C,
        D=D,
        input_names=(*dynamics.joint_names, *(channel.name for channel in forces)),
        output_names=tuple(channel.name for channel in channels),
    )


def _rows(
    dynamics: Dynamics,
    q: ArrayLike,
    channels: Sequence[Channel],
    kind: sensing.RowFunction,
    deflection: ArrayLike | None,
) -> Array:
    assembly = dynamics.assembly
    if channels:
        full = dynamics.position(q, deflection)
        pin.computeJointJacobians(assembly.model, assembly.data, full)
    return _rows_there(dynamics, channels, kind)


def _rows_there(
    dynamics: Dynamics, channels: Sequence[Channel], kind: sensing.RowFunction
) -> Array:
    """Return rows at the pose whose Jacobians were computed last."""
    assembly = dynamics.assembly
    count = len(assembly.flexible)
    if not channels:
        return np.zeros((0, dynamics.n_dof + len(dynamics.joint_names)))
    columns = np.concatenate([assembly.flexible, assembly.drives])
    found = kind(assembly, assembly.data, channels, columns)
    motors = np.zeros((len(channels), dynamics.n_dof - count))
    return np.hstack([found[:, :count], motors, found[:, count:]])
