"""What stands between what moves and what is read: high-passes, and delays of the force.

In come records and spectra; out go FRFs as they are without it.  Samples that were lost
are refused.
"""

from impact_testing.measuring_chain.applied_window import check_unwindowed
from impact_testing.measuring_chain.chain import MeasuringChain, without_chain
from impact_testing.measuring_chain.corner import Corner
from impact_testing.measuring_chain.drift import without_drift
from impact_testing.measuring_chain.force_corner import force_corner, restored
from impact_testing.measuring_chain.lost_samples import check_measured

__all__ = [
    'Corner',
    'MeasuringChain',
    'check_measured',
    'check_unwindowed',
    'force_corner',
    'restored',
    'without_chain',
    'without_drift',
]
