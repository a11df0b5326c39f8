"""A hypothesis about the cell, and the arm in it as a linear system at each pose.

In come a robot model and its sensors; out go modal systems with their tolerances: what is known
only to a percent or so and must not be given a name.
"""

from model_gap.cell.arm_nuisances import encoder_nuisance, encoder_of
from model_gap.cell.cell_model import CellModel, Filter, HeldTorque, JointForce, Ripple, Tone
from model_gap.cell.changes import change_drive, change_joint, gain_step, offset_joint
from model_gap.cell.joint_vector import (
    axis_row,
    BETWEEN_LINKS,
    force_vector,
    in_words,
    is_coupled,
    joint_spring,
    joint_vector,
    marked,
    plain_joint,
)
from model_gap.cell.nuisance import Nuisance, RELATIVE
from model_gap.cell.pose_system import (
    pose_arm,
    pose_system,
    PoseArm,
    PoseSystem,
    sag,
    with_channels,
)
from model_gap.cell.tolerances import nuisances, Tolerances

__all__ = [
    'BETWEEN_LINKS',
    'RELATIVE',
    'CellModel',
    'Filter',
    'HeldTorque',
    'JointForce',
    'Nuisance',
    'PoseArm',
    'PoseSystem',
    'Ripple',
    'Tolerances',
    'Tone',
    'axis_row',
    'change_drive',
    'change_joint',
    'encoder_nuisance',
    'encoder_of',
    'force_vector',
    'gain_step',
    'in_words',
    'is_coupled',
    'joint_spring',
    'joint_vector',
    'marked',
    'nuisances',
    'offset_joint',
    'plain_joint',
    'pose_arm',
    'pose_system',
    'sag',
    'with_channels',
]
