"""The robot a recording was made on, by the name it carries, where its files are here."""

from typing import TYPE_CHECKING

from autonomous_modal_analysis.plan_record import recorded_robot_name
from modal_core.errors import ModalAnalysisError
from modal_recordings.open_recording import Recording
from structural_model.robot_files import load_robot

if TYPE_CHECKING:
    from structural_model.flexible_joint_model import FlexibleJointModel


def robot_of(recording: Recording) -> 'FlexibleJointModel | None':
    """Return the shipped robot a recording names; None where it names none, or another."""
    name = recorded_robot_name(recording)
    # A name of a recording never is a path.
    if not name or '/' in name or '\\' in name:
        return None
    try:
        model = load_robot(name)
    except ModalAnalysisError:
        return None
    return model if model.robot_name == name else None
