"""From evidence to a verdict: named, ambiguous, unexplained or none.

In come the explanations of a search; out go the verdict, where the gap is, and which recording
would tell two explanations apart.
"""

from model_gap.decide.adequacy import Adequacy, adequacy
from model_gap.decide.decide import AGREEING, decide, Decision, LIMITS, objections, untold, Verdict
from model_gap.decide.least_seen import least_seen, LeastSeen
from model_gap.decide.locate import gap_fraction, locate, noise_floor, Where
from model_gap.decide.open_places import open_places
from model_gap.decide.telling_apart import all_fitted, NextRecording, Sight, Telling, telling_apart
from model_gap.decide.what_remains import what_remains

__all__ = [
    'AGREEING',
    'LIMITS',
    'Adequacy',
    'Decision',
    'LeastSeen',
    'NextRecording',
    'Sight',
    'Telling',
    'Verdict',
    'Where',
    'adequacy',
    'all_fitted',
    'decide',
    'gap_fraction',
    'least_seen',
    'locate',
    'noise_floor',
    'objections',
    'open_places',
    'telling_apart',
    'untold',
    'what_remains',
]
