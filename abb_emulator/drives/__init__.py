"""What moves the emulated motors: moves planned within limits, servo, supervision.

In come targets or references; out go motor angles, or a stop with its reason.
"""

from abb_emulator.drives.joint_move import JointMove, MoveLimits
from abb_emulator.drives.motion import CommandedMotion, Stop
from abb_emulator.drives.servo import Servo, ServoSettings
from abb_emulator.drives.supervision import Supervision

__all__ = [
    'CommandedMotion',
    'JointMove',
    'MoveLimits',
    'Servo',
    'ServoSettings',
    'Stop',
    'Supervision',
]
