"""A search on all poses, for what the fitted ones cannot tell; the held-out ones still check it.

Where tolerances explain the fitted poses but not those held out, the fitted ones hardly see what
the model lacks.  All poses together do.  What they show is then fitted to the fitted poses alone,
and must predict the others better by what an effect is worth: they took part in the choice of the
effect, but not of its numbers.
"""

from dataclasses import replace
import logging

import numpy as np

from modal_core.work.progress import Progress
from model_gap.campaign import Campaign
from model_gap.fit import FIT, Fit, fit, posterior_predictive_check
from model_gap.hypothesis import Hypothesis
from model_gap.search.run import run_search
from model_gap.search.search import Search

log = logging.getLogger(__name__)
NOTE = (
    'the fitted poses alone do not tell what is missing: it was sought in all of them, fitted to '
    'the same ones as before, and predicts the held-out ones better'
)


def search_on_all(search: Search, progress: Progress = lambda _: None) -> Search:
    """Return a search with what all poses show and the held-out ones confirm, else as it was.

    Parameters
    ----------
    search : Search
        That found nothing in the fitted poses which the held-out ones confirm.
    progress : callable
        Takes the fraction done.
    """
    begun = Search.begin(search.model, _all_fitted(search), search.settings, search.simulated)
    found = run_search(replace(begun, doubted=True), progress)
    if not found.accepted:
        return search
    last = found.accepted[-1]
    divided = replace(found, campaign=search.campaign).with_data_about(last.fit.hypothesis.cell())
    before = _fitted_again(divided, replace(search.rounds[0].before.hypothesis, scene=found.scene))
    final = _fitted_again(divided, last.fit.hypothesis)
    gain = _predicts_better(divided, final, before)
    log.debug('%s: %.4g of log evidence in held-out poses', final.hypothesis.effects, gain)
    if gain < search.settings.worth_adding * len(final.hypothesis.effects):
        return search
    rounds = [
        replace(found.rounds[0], before=before, heldout_before=_misfit(divided, before)),
        *found.rounds[1:],
    ]
    best = replace(last, fit=final, heldout_misfit=_misfit(divided, final))
    number = len(found.accepted) - 1
    others = rounds[number].candidates[1:]
    rounds[number] = replace(rounds[number], candidates=(best, *others))
    return replace(
        divided,
        campaign=replace(search.campaign, notes=(*search.campaign.notes, NOTE)),
        current=final,
        rounds=tuple(rounds),
        accepted=(*found.accepted[:-1], best),
    )


def _misfit(search: Search, fitted: Fit) -> float:
    return search.heldout_misfit(fitted.hypothesis)


def _all_fitted(search: Search) -> Campaign:
    records = tuple(replace(record, heldout=False) for record in search.campaign.records)
    return replace(search.campaign, records=records)


def _fitted_again(search: Search, hypothesis: Hypothesis) -> Fit:
    return fit(hypothesis, search.data.fitting, iterations=5).without_columns


def _predicts_better(search: Search, one: Fit, other: Fit) -> float:
    """Return by how much log evidence held-out poses prefer the first of two fits."""
    misfits = [posterior_predictive_check(it, search.data.heldout)[0] for it in (one, other)]
    return float(FIT.effective_data * np.log(misfits[1] / misfits[0]))
