"""A set of effects with numbers, on an arm with tolerances.

In come effects of the catalogue; out go cells to predict with, and what a model already knows.
"""

from model_gap.hypothesis.hypothesis import Hypothesis
from model_gap.hypothesis.known_effects import corrected_layout, known_effects, with_known_effects
from model_gap.hypothesis.more_general import is_special_case, more_general
from model_gap.hypothesis.stretched import DOUBTFUL, instead_of_tolerances, stretch, STRETCHED

__all__ = [
    'DOUBTFUL',
    'STRETCHED',
    'Hypothesis',
    'corrected_layout',
    'instead_of_tolerances',
    'is_special_case',
    'known_effects',
    'more_general',
    'stretch',
    'with_known_effects',
]
