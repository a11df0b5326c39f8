"""Exact Gaussian-process regression on linear rows of unknown functions of the pose.

In come rows, residuals and their standard deviations; out go scales by marginal likelihood and
the posterior of the functions at any pose.
"""

from workspace_map.regression.calibration import deviation_factor
from workspace_map.regression.evidence import evidence_of, most_probable_scales
from workspace_map.regression.kernel import covariance, likeness, Rows
from workspace_map.regression.posterior import Posterior, posterior, Shared
from workspace_map.regression.scales import Scales

__all__ = [
    'Posterior',
    'Rows',
    'Scales',
    'Shared',
    'covariance',
    'deviation_factor',
    'evidence_of',
    'likeness',
    'most_probable_scales',
    'posterior',
]
