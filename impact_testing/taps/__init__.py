"""Taps in a record: found, judged one by one, and told to whoever holds the hammer.

In come force and responses; out go taps with their faults, and what to do about them.
"""

from impact_testing.taps.judge import (
    begin_of,
    BEHIND_S,
    Fault,
    FILTER_SAMPLES,
    gaps,
    judge_taps,
    JudgedTap,
    usual_length,
    with_length,
)
from impact_testing.taps.points import FEWEST_TAPS, points_of
from impact_testing.taps.search import find_taps, ForceLevel, Tap, taps_of
from impact_testing.taps.tap_judge import Guidance, TapJudge

__all__ = [
    'BEHIND_S',
    'FEWEST_TAPS',
    'FILTER_SAMPLES',
    'Fault',
    'ForceLevel',
    'Guidance',
    'JudgedTap',
    'Tap',
    'TapJudge',
    'begin_of',
    'find_taps',
    'gaps',
    'judge_taps',
    'points_of',
    'taps_of',
    'usual_length',
    'with_length',
]
