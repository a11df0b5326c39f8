"""Lines that move with the speed of a machine: found, followed, and taken out of samples.

In come uniform samples; out go the orders of shafts whose speed changes, and what is left without
them.  Nothing needs to be known of the machine: all orders of a shaft move by the same factor.
Where the speed of its spindle is measured, it tells the course.
"""

from oma_identifier.moving_lines.course import (
    Course,
    find_course,
    known_course,
    measured_course,
)
from oma_identifier.moving_lines.crossed import with_moving
from oma_identifier.moving_lines.removal import (
    by_modes,
    by_notch,
    Gain,
    MovingLine,
    without_moving,
)
from oma_identifier.moving_lines.thresholds import MOVING
from oma_identifier.moving_lines.wavering import wavering_course

__all__ = [
    'MOVING',
    'Course',
    'Gain',
    'MovingLine',
    'by_modes',
    'by_notch',
    'find_course',
    'known_course',
    'measured_course',
    'wavering_course',
    'with_moving',
    'without_moving',
]
