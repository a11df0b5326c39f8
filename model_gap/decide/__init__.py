"""From evidence to a verdict: named, ambiguous, unexplained or none.

In come the explanations of a search; out go the verdict, where the gap is, and which recording
would tell two explanations apart.
"""

from model_gap.decide.decide import decide, Decision, Verdict
from model_gap.decide.locate import gap_fraction, locate, noise_floor, Where

__all__ = [
    'Decision',
    'Verdict',
    'Where',
    'decide',
    'gap_fraction',
    'locate',
    'noise_floor',
]
