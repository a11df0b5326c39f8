"""The robot a recording was made on, and its sensors: what it carries, or names of those here."""

from collections.abc import Iterable
import logging
from typing import TYPE_CHECKING

from autonomous_modal_analysis.identified.plan_record import recorded_robot_name
from modal_core.channel import SensorLayout
from modal_core.errors import ModalAnalysisError
from modal_core.layouts.shipped_layouts import shipped_layout
from modal_recordings.messages import as_text, attached, attached_layout
from modal_recordings.open_recording import Recording
from structural_model.robot_files import load_robot, MODEL_FILE, robot_of_files, URDF_FILE

if TYPE_CHECKING:
    from structural_model.flexible_joint_model import FlexibleJointModel

log = logging.getLogger(__name__)


def robot_of(recording: Recording) -> 'FlexibleJointModel | None':
    """Return the robot a recording carries, else the shipped one it names; None without either."""
    try:
        carried = _carried_robot(recording)
    except ModalAnalysisError as error:
        log.warning('the robot in the recording is not used: %s', error)
        carried = None
    return _named_robot(recording) if carried is None else carried


def layout_of(
    recording: Recording, robot_name: str, channel_names: Iterable[str]
) -> SensorLayout | None:
    """Return the layout a recording carries, else the shipped one of its robot.

    Parameters
    ----------
    recording : Recording
        Where to look.
    robot_name : str
        As a plan or a robot's description has it.
    channel_names : iterable of str
        All must be in the layout: where some are not, the others need not be those.
    """
    wanted = tuple(channel_names)
    try:
        carried = attached_layout(recording.attachments(), str(recording.path))
    except ModalAnalysisError as error:
        log.warning('the sensor layout in the recording is not used: %s', error)
        carried = None
    if carried is not None and set(wanted) <= {channel.name for channel in carried.channels}:
        return carried
    return shipped_layout(robot_name, wanted)


def _carried_robot(recording: Recording) -> 'FlexibleJointModel | None':
    attachments, where = recording.attachments(), str(recording.path)
    urdf, model = attached(attachments, URDF_FILE), attached(attachments, MODEL_FILE)
    if urdf is None or model is None:
        return None
    return robot_of_files(urdf, as_text(model, f'{where}: {MODEL_FILE}'), where)


def _named_robot(recording: Recording) -> 'FlexibleJointModel | None':
    name = recorded_robot_name(recording)
    # A name of a recording never is a path.
    if not name or '/' in name or '\\' in name:
        return None
    try:
        model = load_robot(name)
    except ModalAnalysisError:
        return None
    return model if model.robot_name == name else None
