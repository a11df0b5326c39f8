"""A plan as a RAPID program: in come a plan and options; out goes a module to load by hand.

Moves are told to the controller such that it makes the planned ones of its own limits.
"""

from excitation_planner.rapid.programmed_move import MOST_OFF, programmed_moves
from excitation_planner.rapid.rapid import (
    HASH_DIGITS,
    module_name,
    rapid_module,
    session_s,
    start_tolerance_deg,
)

__all__ = [
    'HASH_DIGITS',
    'MOST_OFF',
    'module_name',
    'programmed_moves',
    'rapid_module',
    'session_s',
    'start_tolerance_deg',
]
