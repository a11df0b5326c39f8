"""Selected modes refined by maximum likelihood.

In come selected modes and the samples; out go the modes that the likelihood describes better,
with honest deviations; the others stay as they were. Missing modes are sought, superfluous ones
left out, and what a window taught is where the next begins.
"""

from oma_identifier.refinement.acceptance import Outcome, TAKEN
from oma_identifier.refinement.adopt import adopt_refined, Adopted, NEW, Refiner
from oma_identifier.refinement.refinement import refine
from oma_identifier.refinement.thresholds import REFINEMENT

__all__ = [
    'NEW',
    'REFINEMENT',
    'TAKEN',
    'Adopted',
    'Outcome',
    'Refiner',
    'adopt_refined',
    'refine',
]
