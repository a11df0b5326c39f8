"""Torques between motor and link that a spring and a damper do not give.

In come deflections and speeds of a joint, step by step; out go torques: play, friction, stiffness
that grows with deflection or changes with speed, springs that slip, stops.
"""

from model_gap.laws.backlash import BacklashLaw
from model_gap.laws.cubic import CubicLaw
from model_gap.laws.cubic_damping import CubicDampingLaw
from model_gap.laws.friction import FrictionLaw, JointFrictionLaw
from model_gap.laws.friction_curve import FrictionCurveLaw, WholeFrictionCurveLaw
from model_gap.laws.hysteresis import HysteresisLaw
from model_gap.laws.law import Array, Follow, JointContext, JointLaw, SpringLaw
from model_gap.laws.speed_stiffness import SpeedStiffnessLaw
from model_gap.laws.step import stepped
from model_gap.laws.stop import StopLaw

__all__ = [
    'Array',
    'BacklashLaw',
    'CubicDampingLaw',
    'CubicLaw',
    'Follow',
    'FrictionCurveLaw',
    'FrictionLaw',
    'HysteresisLaw',
    'JointContext',
    'JointFrictionLaw',
    'JointLaw',
    'SpeedStiffnessLaw',
    'SpringLaw',
    'StopLaw',
    'WholeFrictionCurveLaw',
    'stepped',
]
