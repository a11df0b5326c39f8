"""The effects that explain the gap, found round by round.

In come records and a catalogue; out go fitted explanations, best first, and their rivals:
candidates are screened, fitted and refined until nothing is left to gain.
"""

from model_gap.search.reach import joint_shares
from model_gap.search.rivals import EVIDENCE_BETWEEN
from model_gap.search.run import run_search
from model_gap.search.search import Candidate, RivalPair, Round, Search, SearchSettings

__all__ = [
    'EVIDENCE_BETWEEN',
    'Candidate',
    'RivalPair',
    'Round',
    'Search',
    'SearchSettings',
    'joint_shares',
    'run_search',
]
