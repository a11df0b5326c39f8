"""The rigid arm in numpy, many instants at once: where its parts are and how they move.

In come a described arm and joint angles; out go frames, places, speeds and distances.
"""

from structural_model.rigid.frame_tree import FrameTree, LinkPlace
from structural_model.rigid.geometry import Clearance, RobotGeometry
from structural_model.rigid.joint_jacobian import joint_jacobian
from structural_model.rigid.kinematics import (
    FrameMotion,
    point_acceleration,
    point_velocity,
    RigidKinematics,
)

__all__ = [
    'Clearance',
    'FrameMotion',
    'FrameTree',
    'LinkPlace',
    'RigidKinematics',
    'RobotGeometry',
    'joint_jacobian',
    'point_acceleration',
    'point_velocity',
]
