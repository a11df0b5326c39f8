"""Laws of which a good explanation is a special case: named only where they say more.

A more general law always fits as well, so that beside its special case it would be a rival of
equal worth: it takes that place only where it explains the recordings better by more than two
explanations are told apart by.
"""

from collections.abc import Sequence
import logging

from model_gap.effects import Effect
from model_gap.fit import Fit, fit, fits
from model_gap.hypothesis import Hypothesis, is_special_case, more_general
from model_gap.search.evidence_bound import evidence_bound
from model_gap.search.refine import best_of_each
from model_gap.search.rivals import EVIDENCE_BETWEEN
from model_gap.search.search_data import SearchData

log = logging.getLogger(__name__)


def generalised(
    found: Sequence[Fit], catalogue: Sequence[type[Effect]], data: SearchData
) -> list[Fit]:
    """Return fits, general laws instead of special cases where these leave much more over.

    Parameters
    ----------
    found : sequence of Fit
        The best first.
    catalogue : sequence of Effect types
        With ``special_case``.
    data : SearchData
        Records.
    """
    every = best_of_each([_general(item, catalogue, data) for item in found])
    return [item for item in every if not _no_better(item, every)]


def _no_better(item: Fit, every: Sequence[Fit]) -> bool:
    """Return whether its special case explains as much as two explanations are told apart by."""
    effect = item.hypothesis.effects[-1]
    return any(
        is_special_case(other.hypothesis.effects[-1], effect)
        and item.log_evidence - other.log_evidence <= EVIDENCE_BETWEEN
        for other in every
    )


def _general(item: Fit, catalogue: Sequence[type[Effect]], data: SearchData) -> Fit:
    """Return the best law that a fit is a special case of, or the fit itself."""
    starts = more_general(item.hypothesis, catalogue)
    if not starts or evidence_bound(item) < EVIDENCE_BETWEEN:
        return item

    def coarsely(start: Hypothesis) -> Fit:
        return fit(start, data.coarse, iterations=8, relinearise=1)

    rough = best_of_each(fits(coarsely, starts))
    fine = fits(
        lambda start: fit(start, data.fitting, iterations=4, relinearise=1),
        [one.hypothesis for one in rough],
    )
    for other in best_of_each(fine)[:1]:
        lead = other.log_evidence - item.log_evidence
        effects = other.hypothesis.effects[-1], item.hypothesis.effects[-1]
        log.debug('%r leads its special case %r by %.3g of log evidence', *effects, lead)
        if lead > EVIDENCE_BETWEEN:
            return other
    return item
