"""The effects that explain the gap, found round by round.

In come records and a catalogue; out go fitted explanations, best first, and their rivals:
candidates are screened, fitted and refined until nothing is left to gain.
"""

from model_gap.search.all_poses import search_on_all
from model_gap.search.evidence_bound import evidence_bound, tolerance_excess
from model_gap.search.joint_screening import is_linear
from model_gap.search.reach import joint_shares
from model_gap.search.rivals import EVIDENCE_BETWEEN
from model_gap.search.run import run_search, tolerances_only
from model_gap.search.screen import larger
from model_gap.search.search import Candidate, RivalPair, Round, Search, SearchSettings
from model_gap.search.search_data import of_first_poses, shortened
from model_gap.search.steps import fit_tolerances
from model_gap.search.thresholds import SEARCH

__all__ = [
    'EVIDENCE_BETWEEN',
    'SEARCH',
    'Candidate',
    'RivalPair',
    'Round',
    'Search',
    'SearchSettings',
    'evidence_bound',
    'fit_tolerances',
    'is_linear',
    'joint_shares',
    'larger',
    'of_first_poses',
    'run_search',
    'search_on_all',
    'shortened',
    'tolerance_excess',
    'tolerances_only',
]
