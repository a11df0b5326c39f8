"""The robot and its sensors, as people name them."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Union

from modal_core.channel import SensorLayout
from modal_core.layouts.layout_file import layout_from_file

if TYPE_CHECKING:
    from structural_model.flexible_joint_model import FlexibleJointModel

Layout = SensorLayout | Mapping[str, object] | str | Path
Robot = Union[str, Path, 'FlexibleJointModel']


def read_layout(layout: Layout | None) -> SensorLayout | None:
    """Return a sensor layout: itself, as a mapping with ``sensors``, or a YAML file of one.

    Raises
    ------
    LayoutError, SettingsError
        It cannot be read or is not a layout.
    """
    if layout is None or isinstance(layout, SensorLayout):
        return layout
    if isinstance(layout, Mapping):
        return SensorLayout.from_mapping(layout, 'layout')
    return layout_from_file(Path(layout))


def read_robot(robot: Robot) -> 'FlexibleJointModel':
    """Return the model of a robot: itself, a shipped robot by name, its folder or model file.

    Raises
    ------
    ModelError
        There is no such robot, or its files are malformed.
    """
    # With the library of rigid bodies, some 50 MB.
    from structural_model.robot_files import load_robot

    return load_robot(robot) if isinstance(robot, str | Path) else robot


def sensors_of(
    robot: Robot | None, model: 'FlexibleJointModel | None', layout: Layout | None
) -> SensorLayout | None:
    """Return the layout that is given, else the robot's own; None without either.

    Raises
    ------
    ModalAnalysisError
        It cannot be read, or does not fit the robot.
    """
    sensors = read_layout(layout)
    if model is None:
        return sensors
    if sensors is None and isinstance(robot, str | Path):
        from structural_model.robot_files import load_layout

        sensors = load_layout(robot)
    if sensors is not None:
        model.check_layout(sensors)
    return sensors
