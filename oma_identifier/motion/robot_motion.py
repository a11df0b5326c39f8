"""What the identifier may ask of a robot model; it knows no model itself."""

from collections.abc import Sequence
import importlib
from typing import cast, Protocol

import numpy as np
from numpy.typing import NDArray

from modal_core.channel import Channel
from modal_core.measurements import JointSamples

LOADER = ('structural_model.robot_files', 'load_robot')
"""Where a robot is found by name, looked up when one is asked for."""


class RobotMotion(Protocol):
    """The rigid arm: what sensors read and how fast motors turn, out of the joint motion."""

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Joints, in the order of the columns below."""

    @property
    def link_names(self) -> tuple[str, ...]:
        """Links a sensor can sit on."""

    @property
    def axis_names(self) -> tuple[str, ...]:
        """Names of the controller axes."""

    def to_controller(self, q: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the angles of the controller axes, (n_samples, n_joints) [rad]."""

    def rigid_acceleration(
        self,
        q: NDArray[np.float64],
        qd: NDArray[np.float64],
        qdd: NDArray[np.float64],
        channels: Sequence[Channel],
    ) -> NDArray[np.float64]:
        """Return the readings of a rigid arm, gravity included, (n_samples, n_channels)."""

    def drive_angle(self, q: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the angle of each motor shaft behind its gear, (n_samples, n_drives) [rad]."""


def load_robot_motion(robot: str) -> RobotMotion:
    """Return the model of a robot by name or folder.

    Raises
    ------
    ModelError
        There is no such robot.
    """
    module, name = LOADER
    return cast(RobotMotion, getattr(importlib.import_module(module), name)(robot))


def in_model_order(joints: JointSamples, robot: RobotMotion) -> NDArray[np.float64] | None:
    """Return positions with a column per joint of the model; None when a joint is missing."""
    if not set(robot.joint_names) <= set(joints.joint_names):
        return None
    columns = [joints.joint_names.index(name) for name in robot.joint_names]
    return joints.position[:, columns]
