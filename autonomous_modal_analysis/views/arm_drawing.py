"""The arm as the report draws it, with what was identified in a recording."""

from autonomous_modal_analysis.identified.results import Identification
from modal_core.channel import SensorLayout
from modal_core.mode import ModeSet
from modal_dashboard.arm_drawing import ArmDrawing, draw_in_pose
from structural_model.flexible_joint_model import FlexibleJointModel


def draw_identified(
    model: FlexibleJointModel,
    layout: SensorLayout,
    identification: Identification,
    modes: ModeSet | None = None,
) -> ArmDrawing | None:
    """Draw modes on the arm, those of the recording by default, in the newest pose it tells.

    None where no pose is known, or a channel is on no known link.
    """
    others = {channel.name for channel in identification.channels if not channel.is_straight}
    shown = identification.modes if modes is None else modes
    poses = [window.pose for window in identification.windows if window.pose is not None]
    return draw_in_pose(model, layout, shown, poses[-1], others) if poses else None
