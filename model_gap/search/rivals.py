"""What is confirmed by held-out records, and what it cannot be told from."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
import logging

import numpy as np

from model_gap.effects import Effect
from model_gap.fit import FIT, Fit, fit, fits
from model_gap.search.evidence_bound import tolerance_excess
from model_gap.search.search import Candidate, RivalPair, Round, Search

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class ConfirmationLimits:
    """When an effect is confirmed, and when another one is its rival.

    Set by healthy campaigns (benchmarks.gap.matrix --calibrate): see
    docs/measured/model_gap.md.

    Parameters
    ----------
    evidence_between : float
        Log evidence by which two explanations can be told apart.
    evidence_near : float
        Log evidence by which a candidate may be behind before it is fitted to the end as the
        accepted ones are: three times that. Chosen, not measured.
    most_worse : float
        χ of held-out records over the least before, at most.
    """

    evidence_between: float = 8.0
    evidence_near: float = 24.0
    most_worse: float = 1.03


CONFIRMATION = ConfirmationLimits()
EVIDENCE_BETWEEN = CONFIRMATION.evidence_between
# A final fit, an accepted effect of it and the candidate to put there instead.
FitInstead = Callable[[Fit, Effect, Candidate], Candidate | None]


def confirm(search: Search) -> Search:
    """Return the search with its accepted effects, and the rivals fitted beside them."""
    accepted = confirmed(search.rounds, search.settings.worth_adding)

    def instead(final: Fit, effect: Effect, other: Candidate) -> Candidate | None:
        return fit_instead(search, final, effect, other)

    def gain(fitted: Fit) -> float:
        return search.gain(fitted, search.rounds[0].before)

    return replace(
        search, accepted=accepted, rivals=rivals_of(search.rounds, accepted, instead, gain)
    )


def confirmed(rounds: Sequence[Round], worth_adding: float) -> tuple[Candidate, ...]:
    """Return the best candidates of the rounds up to the last that held-out records confirm."""
    last, least = 0, np.inf
    for number, done in enumerate(rounds, start=1):
        if not done.earns_place(worth_adding):
            break
        best = done.candidates[0]
        held = _charged(best.heldout_misfit, best.fit)
        least = min(least, _charged(done.heldout_before, done.before))
        if not np.isfinite(held) or held < CONFIRMATION.most_worse * least:
            last = number
        else:
            log.debug(
                '%r not confirmed: misfit of held-out records %.4g, before %.4g',
                best.effect,
                held,
                least,
            )
    return tuple(done.candidates[0] for done in rounds[:last])


def _charged(heldout_misfit: float, fitted: Fit) -> float:
    """Return χ of held-out records with what tolerances cost, as the objective weighs both.

    A tolerance stretched far may predict as well as the effect it stands for.
    """
    return heldout_misfit * float(np.exp(tolerance_excess(fitted) / FIT.effective_data))


def rivals_of(
    rounds: Sequence[Round],
    accepted: Sequence[Candidate],
    fit_instead: FitInstead,
    gain: Callable[[Fit], float],
) -> tuple[RivalPair, ...]:
    """Return what each accepted effect that was kept cannot be told from.

    All are fitted to the end, as the accepted ones are: a fit that stopped short looks worse.
    """
    if not accepted:
        return ()
    final = accepted[-1].fit
    keys = [effect.key for effect in final.hypothesis.effects]
    # What was dropped later needs no rival; what was added later is none.
    near = [
        (best, other)
        for done, best in zip(rounds, accepted, strict=False)
        for other in done.candidates[1:]
        if best.gain - other.gain < CONFIRMATION.evidence_near
        and best.effect.key in keys
        and other.effect.key not in keys
    ]
    if not near:
        return ()
    whole, found = gain(final), []
    for best, other in near:
        beside = fit_instead(final, best.effect, other)
        if beside and whole - gain(beside.fit) < EVIDENCE_BETWEEN:
            found.append(RivalPair(replace(best, fit=final), beside))
    for pair in found:
        log.debug(
            '%r cannot be told from %r: %.3g of log evidence between them',
            pair.accepted.effect,
            pair.rival.effect,
            pair.accepted.fit.log_evidence - pair.rival.fit.log_evidence,
        )
    return tuple(found)


def fit_instead(search: Search, final: Fit, best: Effect, other: Candidate) -> Candidate | None:
    """Return another effect beside all others that were found; None of an impossible arm.

    What two effects of an early round are worth tells little while others are missing.
    """
    place = [effect.key for effect in final.hypothesis.effects].index(best.key)
    fewer, found = final.hypothesis.without(place), other.fit.hypothesis
    if [it.key for it in found.effects[:-1]] == [it.key for it in fewer.effects]:
        start = found
    else:
        start = fewer.with_effect(other.effect, found.values()[-1])
    (fitted,) = fits(lambda it: fit(it, search.data.fitting, relinearise=2), [start])
    return search.candidate(fitted, search.rounds[0].before) if fitted else None
