"""Models of the robots of a history."""

from typing import TYPE_CHECKING

from modal_core.errors import ModalAnalysisError

if TYPE_CHECKING:
    from modal_history.alarm.arm_parts import ArmParts


class RobotParts:
    """Finds the model of a robot, once.

    Parameters
    ----------
    model : str
        Of config/robots, a folder, or a model file, for all robots; empty: the shipped robot of
        the name that the history has, where there is one.
    """

    def __init__(self, model: str = '') -> None:
        self._model = model
        self._known: dict[str, ArmParts | None] = {}

    def arm(self, robot: str) -> 'ArmParts | None':
        """Return the parts of a robot; None where no model of it can be read."""
        if robot not in self._known:
            self._known[robot] = self._load(self._model or robot)
        return self._known[robot]

    def _load(self, name: str) -> 'ArmParts | None':
        # With the library of rigid bodies: a second to load, and 50 MB.
        from modal_history.alarm.arm_parts import ArmParts
        from structural_model.robot_files import load_layout, load_robot

        try:
            model = load_robot(name) if name else None
        except ModalAnalysisError:
            model = None
        if model is None:
            return None
        try:
            return ArmParts(model, load_layout(name))
        except ModalAnalysisError:
            # Modes are told apart by their frequencies then.
            return ArmParts(model)
