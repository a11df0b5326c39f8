"""Effects and tolerances fitted to spectra, with evidence.

In come a hypothesis and records; out go the most probable numbers, their covariance and the
evidence by Laplace's approximation (MacKay 2003, chapter 28).
"""

from model_gap.fit.fit import descend, Fit, fit, free_numbers_cost, Linearised
from model_gap.fit.fits import fits, Numbers, numbers_of, with_numbers
from model_gap.fit.heldout_chance import heldout_chance
from model_gap.fit.linearise import effect_columns, tolerance_columns
from model_gap.fit.partial import fit_some
from model_gap.fit.plausible import cost
from model_gap.fit.posterior_predictive import posterior_predictive_check
from model_gap.fit.split import pose_groups, split
from model_gap.fit.thresholds import FIT

__all__ = [
    'FIT',
    'Fit',
    'Linearised',
    'Numbers',
    'cost',
    'descend',
    'effect_columns',
    'fit',
    'fit_some',
    'fits',
    'free_numbers_cost',
    'heldout_chance',
    'numbers_of',
    'pose_groups',
    'posterior_predictive_check',
    'split',
    'tolerance_columns',
    'with_numbers',
]
