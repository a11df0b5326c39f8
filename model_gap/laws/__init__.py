"""Torques between motor and link that a spring and a damper do not give.

In come deflections and speeds of a joint, step by step; out go torques: play, friction, stiffness
that grows with deflection or changes with speed.
"""

from model_gap.laws.backlash import BacklashLaw
from model_gap.laws.cubic import CubicLaw
from model_gap.laws.friction import FrictionLaw, JointFrictionLaw
from model_gap.laws.law import Follow, JointContext, JointLaw
from model_gap.laws.solve import BACKLASH, stepped
from model_gap.laws.speed_stiffness import SpeedStiffnessLaw

__all__ = [
    'BACKLASH',
    'BacklashLaw',
    'CubicLaw',
    'Follow',
    'FrictionLaw',
    'JointContext',
    'JointFrictionLaw',
    'JointLaw',
    'SpeedStiffnessLaw',
    'stepped',
]
