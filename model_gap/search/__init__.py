"""The effects that explain the gap, found round by round.

In come records and a catalogue; out go fitted explanations, best first: candidates are
screened, fitted and refined until nothing is left to gain.
"""

from model_gap.search.reach import joint_shares
from model_gap.search.search import Candidate, Search, SearchSettings

__all__ = ['Candidate', 'Search', 'SearchSettings', 'joint_shares']
