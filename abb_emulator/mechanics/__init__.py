"""The arm behind the emulated drives: its flexible structure, gears and hidden effects.

In come motor motion and torques; out go deflections and what points of the arm feel, stepped in
time.
"""

from abb_emulator.mechanics.arm import Arm
from abb_emulator.mechanics.arm_effect import ArmEffect, AXES, read_effects
from abb_emulator.mechanics.arm_structure import (
    check_place,
    GAIN_SIGMA,
    PLACE_SIGMA_M,
    with_effects,
    with_tolerances,
)
from abb_emulator.mechanics.gear_settings import GearSettings

__all__ = [
    'AXES',
    'GAIN_SIGMA',
    'PLACE_SIGMA_M',
    'Arm',
    'ArmEffect',
    'GearSettings',
    'check_place',
    'read_effects',
    'with_effects',
    'with_tolerances',
]
