"""Slow ways to where a plan starts, and back after a stop; released as any other plan.

In come two poses and limits; out goes a plan of one move.
"""

from excitation_planner.ways.approach import PART_OF_SPEED, plan_approach
from excitation_planner.ways.way_back import is_there, plan_way_back

__all__ = [
    'PART_OF_SPEED',
    'is_there',
    'plan_approach',
    'plan_way_back',
]
