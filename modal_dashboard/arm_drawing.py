"""The arm as page and report draw it: skeleton and sensors at rest, and how modes move them."""

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from excitation_planner.pose_range import expanded_shapes
from modal_core.channel import SensorLayout
from modal_core.mode import ModeSet
from modal_core.numbers.indicators import normalise, rotate_to_real
from modal_core.window import Pose
from modal_reports import Geometry
from structural_model.flexible_joint_model import FlexibleJointModel


@dataclass(frozen=True, slots=True)
class ArmDrawing:
    """What is needed to draw modes on an arm.

    Parameters
    ----------
    geometry : Geometry
        Skeleton points first, then the sensors.
    displacements : tuple of (n_points, 3) complex array
        One per mode.
    """

    geometry: Geometry
    displacements: tuple[NDArray[np.complex128], ...]

    @property
    def placed(self) -> tuple[Geometry, tuple[NDArray[np.complex128], ...]]:
        """Both, as reports and files of other programs take them."""
        return self.geometry, self.displacements


def draw_in_pose(
    model: FlexibleJointModel,
    layout: SensorLayout,
    modes: ModeSet,
    pose: Pose,
    others: Collection[str] = (),
) -> ArmDrawing | None:
    """Draw modes on the arm where joint states told it was.

    Parameters
    ----------
    model : FlexibleJointModel
        The robot.
    layout : SensorLayout
        Its sensors.
    modes : ModeSet
        Identified modes.
    pose : Pose
        With the robot's joints, in any order.
    others : collection of str
        Channels that need no place: they measure no motion along a direction.

    Returns
    -------
    ArmDrawing or None
        None where a joint or a channel is not the robot's.
    """
    placed = {channel.name for channel in layout.channels}
    if not set(modes.channel_names) - set(others) <= placed:
        return None
    if not set(model.joint_names) <= set(pose.joint_names):
        return None
    columns = [pose.joint_names.index(name) for name in model.joint_names]
    return draw_arm(model, np.asarray(pose.position)[columns], layout, modes)


def draw_arm(
    model: FlexibleJointModel, q: NDArray[np.float64], layout: SensorLayout, modes: ModeSet
) -> ArmDrawing:
    """Place skeleton and sensors, and move them by identified mode shapes.

    Between the sensors the arm is drawn by the model's modes fitted to the measured shape.

    Parameters
    ----------
    model : FlexibleJointModel
        The robot.
    q : (n_joints,) array [rad]
        Pose, serial joints.
    layout : SensorLayout
        Sensors; every channel of ``modes`` is in it.
    modes : ModeSet
        Identified modes.
    """
    skeleton = model.geometry.skeleton(q)
    sensors = model.geometry.positions(
        q[None, :], [(sensor.frame_id, np.array(sensor.position_m)) for sensor in layout]
    )[0]
    links = [link for link, _ in model.geometry.skeleton_points]
    n_skeleton = len(skeleton)
    highest_hz = float(max(modes.frequency_hz, default=0.0))
    geometry = Geometry(
        points_m=np.vstack([skeleton, sensors]),
        lines=(
            tuple(range(n_skeleton)),
            *(
                (links.index(sensor.frame_id), n_skeleton + number)
                for number, sensor in enumerate(layout)
                if sensor.frame_id in links
            ),
        ),
        sensors=tuple(range(n_skeleton, n_skeleton + len(sensors))),
    )
    return ArmDrawing(
        geometry=geometry,
        displacements=tuple(
            _displacement(model, q, layout, modes.channel_names, mode.shape, highest_hz)
            for mode in modes
        ),
    )


def _displacement(
    model: FlexibleJointModel,
    q: NDArray[np.float64],
    layout: SensorLayout,
    channel_names: tuple[str, ...],
    shape: NDArray[np.complex128],
    highest_hz: float,
) -> NDArray[np.complex128]:
    placed = {channel.name: channel for channel in layout.channels if channel.is_straight}
    rows = [row for row, name in enumerate(channel_names) if name in placed]
    channels = tuple(placed[channel_names[row]] for row in rows)
    straight = rotate_to_real(normalise(shape[rows])[:, None])
    dof = expanded_shapes(model, q, channels, straight, highest_hz)
    at_skeleton = model.sensor_jacobian(q, model.geometry.skeleton_channels) @ dof
    moved = model.geometry.to_base(q, at_skeleton.reshape(-1, 3))
    sensor_channels = layout.channels
    at_sensors = model.sensor_jacobian(q, sensor_channels) @ dof
    return np.vstack([moved, _sensors_in_base(model, q, layout, at_sensors[:, 0])]).astype(complex)


def _sensors_in_base(
    model: FlexibleJointModel,
    q: NDArray[np.float64],
    layout: SensorLayout,
    values: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Turn what the axes of each sensor see into vectors in the base frame."""
    origins, tips, first = [], [], 0
    for sensor in layout:
        channels = sensor.channels()
        seen = values[first : first + len(channels)]
        first += len(channels)
        in_link = np.linalg.pinv(np.array([channel.direction for channel in channels])) @ seen
        origins.append((sensor.frame_id, np.zeros(3)))
        tips.append((sensor.frame_id, in_link))
    # At once: each call goes through the whole arm.
    found = model.geometry.positions(q[None, :], [*origins, *tips])[0]
    return np.asarray(found[len(origins) :] - found[: len(origins)])
