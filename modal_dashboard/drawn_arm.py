"""The robot that shapes are drawn on, read when the first shapes come."""

from dataclasses import replace
from typing import TYPE_CHECKING

from modal_core.channel import LAYOUT_FILE, SensorLayout
from modal_core.errors import ModalAnalysisError
from modal_core.layouts.layout_file import layout_from_file
from modal_core.layouts.shipped_layouts import shipped_layout
from modal_dashboard.screens import shapes_update, Update
from modal_history.kept import KeptWindow

if TYPE_CHECKING:
    from modal_dashboard.arm_drawing import ArmDrawing
    from structural_model.flexible_joint_model import FlexibleJointModel


class DrawnArm:
    """Draws shapes on a robot where a result tells its pose and channels; else as bars.

    Parameters
    ----------
    robot : str
        Of config/robots, or its folder; empty: none.

    Attributes
    ----------
    problem : str
        Why no robot is drawn; empty where one can be.
    """

    def __init__(self, robot: str) -> None:
        self._robot, self.problem = robot, ''
        self._model: FlexibleJointModel | None = None

    def update(self, window: KeptWindow) -> Update:
        """Return the shapes of a window's modes; lines of machines have none of the structure."""
        modes = tuple(mode for mode in window.modes if not mode.harmonic)
        window = replace(window, modes=replace(window.modes, modes=modes))
        drawing = self._draw(window)
        if drawing is None:
            return shapes_update(window)
        displacements = drawing.displacements
        return shapes_update(window, drawing.geometry, displacements)

    def _draw(self, window: KeptWindow) -> 'ArmDrawing | None':
        if not self._robot or window.pose is None or not len(window.modes):
            return None
        # With the library of rigid bodies: a second to load, and 50 MB.
        from modal_dashboard.arm_drawing import draw_in_pose

        try:
            model = self._loaded()
            layout = self._layout(model, window.modes.channel_names)
            if layout is None:
                return None
            return draw_in_pose(model, layout, window.modes, window.pose)
        except ModalAnalysisError as error:
            self._robot, self.problem = '', str(error)
            return None

    def _loaded(self) -> 'FlexibleJointModel':
        from structural_model.robot_files import load_robot

        if self._model is None:
            self._model = load_robot(self._robot)
        return self._model

    def _layout(self, model: 'FlexibleJointModel', names: tuple[str, ...]) -> SensorLayout | None:
        from structural_model.robot_files import robot_folder

        found = shipped_layout(model.robot_name, names)
        own = robot_folder(self._robot) / LAYOUT_FILE
        if found is None and own.is_file():
            found = layout_from_file(own)
        return found
