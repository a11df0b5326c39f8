"""What sensors on the arm see: flexible motion, rigid motion, gravity."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
import pinocchio as pin

from modal_core.channel import Channel
from modal_core.units import ANGULAR_ACCELERATION, ANGULAR_VELOCITY
from structural_model.assembly import Assembly
from structural_model.rigid import FrameMotion, joint_jacobian, point_acceleration

Array = NDArray[np.float64]
LAYOUTS_KEPT = 16
ROTATIONS = (ANGULAR_VELOCITY, ANGULAR_ACCELERATION)
RowFunction = Callable[[Assembly, pin.Data, Sequence[Channel], NDArray[np.intp]], Array]


@dataclass(frozen=True)
class SensorMap:
    """Where channels sit, in the axes of the joints they ride on; the same at every pose.

    Parameters
    ----------
    groups : tuple of (joint, (n,) int array)
        Pinocchio joint and the channels on it.
    wrench : (n_channels, 6) array
        Unit force (or torque) along the channel, at the joint's origin.
    direction : (n_channels, 3) array
        Direction of accelerometers; zero for angular velocity channels.
    position : (n_channels, 3) array [m]
        Of the channels.
    """

    groups: tuple[tuple[int, NDArray[np.intp]], ...]
    wrench: Array
    direction: Array
    position: Array


def sensor_map(assembly: Assembly, channels: tuple[Channel, ...]) -> SensorMap:
    """Return where channels sit, remembered for the last few layouts asked for.

    Raises
    ------
    ModelError
        A channel names an unknown link.
    """
    known: dict[tuple[Channel, ...], SensorMap] = assembly.sensor_maps
    found = known.get(channels)
    if found is None:
        if len(known) >= LAYOUTS_KEPT:
            known.clear()
        found = known[channels] = _new_map(assembly, channels)
    return found


def _new_map(assembly: Assembly, channels: tuple[Channel, ...]) -> SensorMap:
    wrench, direction = np.zeros((len(channels), 6)), np.zeros((len(channels), 3))
    position = np.zeros((len(channels), 3))
    joints = np.zeros(len(channels), dtype=np.intp)
    for number, channel in enumerate(channels):
        joints[number], placement = assembly.attach(channel.frame_id, np.array(channel.position_m))
        position[number] = placement.translation
        along = placement.rotation @ np.array(channel.direction)
        if channel.unit in ROTATIONS:
            wrench[number, 3:] = along
        else:  # d·(v + ω × p) = d·v + (p × d)·ω
            wrench[number, :3], direction[number] = along, along
            (px, py, pz), (dx, dy, dz) = placement.translation, along
            wrench[number, 3:] = py * dz - pz * dy, pz * dx - px * dz, px * dy - py * dx
    groups = tuple((int(joint), np.flatnonzero(joints == joint)) for joint in np.unique(joints))
    return SensorMap(groups, wrench, direction, position)


def jacobian_rows(
    assembly: Assembly, data: pin.Data, channels: Sequence[Channel], columns: NDArray[np.intp]
) -> Array:
    """Return the motion along each channel's direction per unit of the chosen coordinates.

    Parameters
    ----------
    assembly : Assembly
        The expanded arm.
    data : pinocchio.Data
        After ``computeJointJacobians`` at the pose.
    channels : sequence of Channel
        Displacement along the direction, or turn about it for an angular velocity channel.
    columns : (n,) int array
        Places in pinocchio's vectors.

    Returns
    -------
    (n_channels, n) array
        In the sensor's own axes.
    """
    found = sensor_map(assembly, tuple(channels))
    rows = np.zeros((len(channels), len(columns)))
    for joint, members in found.groups:
        jacobian = joint_jacobian(assembly.model, data, joint, pin.ReferenceFrame.LOCAL)
        rows[members] = found.wrench[members] @ jacobian[:, columns]
    return rows


def gravity_rows(
    assembly: Assembly, data: pin.Data, channels: Sequence[Channel], columns: NDArray[np.intp]
) -> Array:
    """Return the change of each accelerometer's gravity reading per unit deflection.

    An accelerometer reads d·Rᵀ(a - g); tilting it by θ (sensor axes) adds d·(θ × Rᵀg).

    Parameters
    ----------
    assembly, data, channels, columns
        As for ``jacobian_rows``.

    Returns
    -------
    (n_channels, n) array [m/s²/rad]
        Zero for angular velocity channels.
    """
    found = sensor_map(assembly, tuple(channels))
    rows = np.zeros((len(channels), len(columns)))
    gravity = np.asarray(assembly.model.gravity.linear)
    for joint, members in found.groups:
        jacobian = joint_jacobian(assembly.model, data, joint, pin.ReferenceFrame.LOCAL)
        x, y, z = data.oMi[joint].rotation.T @ gravity
        # -d(Rᵀg) = θ × (Rᵀg), so the reading gains d·(θ × g') = (g' × d)·θ = d·([g']ₓᵀ θ).
        crossed = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
        rows[members] = found.direction[members] @ crossed @ jacobian[3:, columns]
    return rows


def rigid_readings(
    assembly: Assembly, motion: FrameMotion, channels: Sequence[Channel], gravity: Array
) -> Array:
    """Return what the channels read when the arm moves as a rigid one.

    Parameters
    ----------
    assembly : Assembly
        Knows where links sit.
    motion : FrameMotion
        Rigid motion of the joint frames.
    channels : sequence of Channel
        Accelerometer or angular velocity axes.
    gravity : (3,) array [m/s²]
        In the base frame.

    Returns
    -------
    (n, n_channels) array [m/s²] or [rad/s]
        d·Rᵀ(a - g) and d·Rᵀω.
    """
    readings = np.zeros((len(motion.position), len(channels)))
    for number, channel in enumerate(channels):
        joint, placement = assembly.link(channel.frame_id)
        direction = motion.rotation[:, joint] @ (placement.rotation @ np.array(channel.direction))
        if channel.unit == ANGULAR_VELOCITY:
            vector = motion.spin[:, joint]
        else:
            place = placement.act(np.array(channel.position_m))
            vector = point_acceleration(motion, joint, place) - gravity
        readings[:, number] = np.einsum('ni,ni->n', direction, vector)
    return readings
