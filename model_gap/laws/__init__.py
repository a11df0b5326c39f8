"""Torques between motor and link that a spring and a damper do not give."""

from model_gap.laws.backlash import BacklashLaw
from model_gap.laws.cubic import CubicLaw
from model_gap.laws.friction import FrictionLaw, JointFrictionLaw
from model_gap.laws.law import Follow, JointLaw, Surroundings
from model_gap.laws.speed_stiffness import SpeedStiffnessLaw

__all__ = [
    'BacklashLaw',
    'CubicLaw',
    'Follow',
    'FrictionLaw',
    'JointFrictionLaw',
    'JointLaw',
    'SpeedStiffnessLaw',
    'Surroundings',
]
