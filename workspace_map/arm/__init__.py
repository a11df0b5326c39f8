"""The arm at one pose, with what its model may lack, and how its modes follow from that.

In come a flexible-joint model, channels and a tool point; out go modes at a pose and their
derivatives with respect to springs, couplings, masses and dampers.
"""

from workspace_map.arm.arm_at_pose import Arm, ArmAtPose, PAYLOAD_NUMBERS, ToolPoint
from workspace_map.arm.local_modes import local_modes, LocalModes
from workspace_map.arm.slopes import damping_slopes, frequency_slopes, shape_slopes, Slopes
from workspace_map.arm.state import State
from workspace_map.arm.turned import turned_poses, TurnedPose

__all__ = [
    'PAYLOAD_NUMBERS',
    'Arm',
    'ArmAtPose',
    'LocalModes',
    'Slopes',
    'State',
    'ToolPoint',
    'TurnedPose',
    'damping_slopes',
    'frequency_slopes',
    'local_modes',
    'shape_slopes',
    'turned_poses',
]
