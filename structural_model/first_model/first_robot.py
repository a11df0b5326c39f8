"""Files of a robot that only a URDF describes: what it does not say is guessed, and says so."""

from dataclasses import dataclass
from pathlib import Path

from modal_core.channel import LAYOUT_FILE
from structural_model.description import parse_urdf, read_urdf_file
from structural_model.first_model.guess import guessed_model
from structural_model.first_model.one_arm import one_arm, OneArm
from structural_model.first_model.places import guessed_layout
from structural_model.first_model.shapes import with_shapes
from structural_model.flexible_joint_model import FlexibleJointModel
from structural_model.robot_files import MODEL_FILE, URDF_FILE
from structural_model.robot_writer import layout_text

HEADING = """\
# Made from a URDF. Guessed: stiffness [N m/rad], damping, accelerations, jerks, home.
# Put in what you know. ama gap takes them as rough (tolerances) and writes what was measured.
"""


@dataclass(frozen=True)
class FirstRobot:
    """A robot to begin with.

    Parameters
    ----------
    arm : OneArm
        What of the URDF moves.
    model : FlexibleJointModel
        Its stiffnesses, damping and limits of acceleration are guesses.
    files : dict of str to bytes
        Its folder.
    guessed : tuple of str
        What was guessed and how, one statement each.
    """

    arm: OneArm
    model: FlexibleJointModel
    files: dict[str, bytes]
    guessed: tuple[str, ...]


def first_robot(
    urdf: str | Path, tip: str | None = None, lowest_hz: float | None = None
) -> FirstRobot:
    """Return a robot with elastic joints from a URDF.

    Parameters
    ----------
    urdf : path
        The file, expanded if it was a xacro.
    tip : str or None
        Last link of the arm; None: where the moving joints branch or end.
    lowest_hz : float [Hz] or None
        Lowest natural frequency at the home pose, where it is known; stiffnesses are scaled to it.

    Raises
    ------
    ModelError
        Not a URDF, or no arm that could be modelled.
    """
    where = str(urdf)
    arm = one_arm(read_urdf_file(urdf), where, tip)
    robot, boxes = with_shapes(parse_urdf(arm.urdf, where), where)
    model, text, guessed = guessed_model(robot, lowest_hz, where)
    files = {
        URDF_FILE: robot.text,
        MODEL_FILE: (HEADING + text).encode(),
        LAYOUT_FILE: layout_text(guessed_layout(robot, arm.tip)).encode(),
    }
    return FirstRobot(arm, model, files, (*guessed, *boxes))
