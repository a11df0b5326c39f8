"""A robot arm as it is described: rigid arm, flexibilities, limits, poses."""

from collections.abc import Mapping
import dataclasses
from dataclasses import dataclass, fields
import math
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from modal_core.channel import SensorLayout
from modal_core.errors import LayoutError, ModelError
from structural_model.assembly import correctable_links
from structural_model.description import (
    AxisMap,
    check_length,
    ModelSpec,
    pose_words,
    read_parameters,
    RigidRobot,
    RobotLimits,
    shown,
    write_parameters,
)

Array = NDArray[np.float64]
SENSOR_REACHES = 3.0
"""What a link carries lies within the arm's reach of it; more than twice that is for tools."""
FARTHEST_SENSOR_M = 10.0
"""Allowed of any arm: joints of one origin reach nowhere, and a table on them has a size."""


@dataclass(frozen=True, eq=False, repr=False)
class ArmDescription:
    """What a robot is, by its files.

    Parameters
    ----------
    robot : RigidRobot
        The rigid arm of the URDF.
    spec : ModelSpec
        Everything the URDF does not say.
    limits : RobotLimits
        What the axes may do; holds the map between serial joints and controller axes.
    poses_controller_rad : dict of str to tuple [rad]
        Named poses in controller angles.
    collision_ignore : tuple of (link, link)
        Pairs that may touch.
    name : str
        Name of the robot; that of the URDF when empty.
    """

    robot: RigidRobot
    spec: ModelSpec
    limits: RobotLimits
    poses_controller_rad: Mapping[str, tuple[float, ...]]
    collision_ignore: tuple[tuple[str, str], ...] = ()
    name: str = ''

    def __getstate__(self) -> dict[str, object]:
        """Leave out what is worked out on demand: another process does it again."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @property
    def robot_name(self) -> str:
        """Name of the robot."""
        return self.name or self.robot.name

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Moving joints, in the order of every q."""
        return self.robot.joint_names

    @property
    def link_names(self) -> tuple[str, ...]:
        """Links a sensor can sit on."""
        return self.robot.link_names

    @property
    def body_links(self) -> tuple[str, ...]:
        """Moving links whose masses a model may correct: not frames fixed to them elsewhere."""
        return correctable_links(self.robot)

    @property
    def axis_names(self) -> tuple[str, ...]:
        """Names of the controller axes, in the order of the serial joints."""
        return self.limits.axis_names

    @property
    def axes(self) -> AxisMap:
        """The map between serial joints and controller axes."""
        return self.limits.axes

    @property
    def n_joints(self) -> int:
        """Number of moving joints."""
        return len(self.robot.joints)

    def to_serial(self, controller_rad: ArrayLike) -> Array:
        """Return serial joint angles of controller (ABB) angles, (..., n_joints) [rad]."""
        return self.axes.to_serial(check_length(controller_rad, self.joint_names, self.robot_name))

    def to_controller(self, serial_rad: ArrayLike) -> Array:
        """Return controller (ABB) angles of serial joint angles, (..., n_joints) [rad]."""
        return self.axes.to_controller(check_length(serial_rad, self.joint_names, self.robot_name))

    def pose(self, name: str) -> Array:
        """Return a named pose as serial joint angles [rad].

        Raises
        ------
        ModelError
            No such pose.
        """
        if name not in self.poses_controller_rad:
            raise ModelError(
                'unknown pose',
                where=self.robot_name,
                found=name,
                expected=', '.join(self.poses_controller_rad),
            )
        return self.to_serial(self.poses_controller_rad[name])

    def usual_pose(self) -> Array:
        """Return the first named pose; of a robot without one, zero, or as near as ranges allow.

        Serial joints, (n_joints,) [rad].
        """
        if self.poses_controller_rad:
            return self.pose(next(iter(self.poses_controller_rad)))
        limits = self.limits
        axes = np.clip(np.zeros(self.n_joints), limits.controller_low, limits.controller_high)
        return np.clip(self.to_serial(axes), limits.position_low, limits.position_high)

    @property
    def sliding(self) -> tuple[bool, ...]:
        """Which joints slide, in the order of every q."""
        return tuple(joint.prismatic for joint in self.robot.joints)

    def shown_axes(self, q: ArrayLike) -> Array:
        """Return controller axes of a pose [deg], [m] of those that slide, (..., n_joints)."""
        return shown(self.to_controller(q), self.sliding)

    def axes_words(self, q: ArrayLike, digits: int = 1) -> str:
        """Return controller axes for people, each with its unit where these differ."""
        return pose_words(self.shown_axes(q), self.sliding, digits)

    def joints_words(self, q: ArrayLike, digits: int = 0) -> str:
        """Return serial joints for people, each with its unit where these differ."""
        return pose_words(shown(q, self.sliding), self.sliding, digits)

    def check_pose(self, q: ArrayLike) -> Array:
        """Return q when it has the right length and lies inside all ranges.

        Raises
        ------
        ModelError
            With joint, angle and range.
        """
        values = check_length(q, self.joint_names, self.robot_name)
        self.limits.check_pose(values, self.robot_name, self.sliding)
        return values

    def check_layout(self, layout: SensorLayout) -> None:
        """Refuse a sensor on a link there is none of, or far off its link.

        Raises
        ------
        LayoutError
            Naming the sensor.
        """
        layout.check_links(self.link_names, self.robot_name)
        farthest_m = max(FARTHEST_SENSOR_M, SENSOR_REACHES * self.robot.reach_m)
        for sensor in layout:
            away_m = math.hypot(*sensor.position_m)
            if away_m > farthest_m:
                raise LayoutError(
                    f'sensor {sensor.name} sits far off its link',
                    where=layout.name,
                    found=f'{away_m:.4g} m from the origin of {sensor.frame_id}',
                    expected=f'at most {farthest_m:.3g} m',
                    advice='position_m is in metres',
                )

    def replace(self, spec: ModelSpec) -> Self:
        """Return this robot with other flexibilities, masses or dampers."""
        return dataclasses.replace(self, spec=spec)

    def parameters(self) -> dict[str, float]:
        """Return every number of the spec by dotted name, such as ``masses.tool.mass_kg``."""
        return read_parameters(self.spec)

    def with_parameters(self, values: Mapping[str, float]) -> Self:
        """Return the model with some numbers of the spec changed.

        Raises
        ------
        ModelError
            A name is unknown.
        """
        return self.replace(write_parameters(self.spec, values))
