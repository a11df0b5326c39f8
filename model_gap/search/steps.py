"""The steps of a round, each a state of the search in and a state out."""

from dataclasses import dataclass, replace
from functools import partial
import logging

from model_gap.effects import same
from model_gap.fit import Fit, fit, fit_some, tolerance_columns
from model_gap.search.evidence_bound import evidence_bound, tolerance_excess
from model_gap.search.generalise import generalised
from model_gap.search.hanging import hanging
from model_gap.search.joint_screening import screen_jointly
from model_gap.search.lines import lines_left
from model_gap.search.orders import orders_left
from model_gap.search.reach import within_reach
from model_gap.search.refine import fine_fits, REFINEMENT, rough_fits
from model_gap.search.screen import Projection, screen, Trial
from model_gap.search.search import Round, Search

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class StepLimits:
    """What decides which steps of a round are worth their time.

    Parameters
    ----------
    least_reach_gain, least_reach_share : float
        An effect is tried only where a free force could gain so much log evidence, and this share
        of the best place.
    least_promise, least_further_promise : float
        Nothing is refined when the best promises less than this share of what is worth adding,
        as the first effect and as a further one.
    open_misfit, closed_share : float
        Below this misfit a linear trial says enough; nor is more needed where one promises such a
        share of the evidence bound.
    distorted_misfit : float
        A misfit this large means that the fit without an effect is distorted: candidates are then
        tried on the nominal model.
    near_misfit : float
        Of a misfit so small not all is resonance: hums stand out of it.
    first_linearisations : int
        Tolerances alone go far where an effect is missing: a fit that stopped short misleads.
    rough_linearisations : int
        The same where tolerances are wider than usual: the way to the right springs is long.
    linear_lead : float
        Log evidence by which a linear simulation must explain recordings better than a moving arm.
    """

    least_reach_gain: float = 3.0
    least_reach_share: float = 0.1
    least_promise: float = 0.5
    least_further_promise: float = 1.0
    open_misfit: float = 1.1
    closed_share: float = 0.8
    distorted_misfit: float = 4.0
    near_misfit: float = 30.0
    first_linearisations: int = 3
    rough_linearisations: int = 12
    linear_lead: float = 3.0


LIMITS = StepLimits()


def fit_tolerances(search: Search) -> Search:
    """Fit the model without any effect, before the first round."""
    often, rough = LIMITS.first_linearisations, search.rough_places
    if rough:
        often = LIMITS.rough_linearisations
        begun = fit_some(search.nominal, search.data.coarse, rough, often)
        search = replace(search, roughly_known=begun.tolerance_values)
    first = fit(search.unstretched, search.data.fitting, relinearise=often)
    log.debug('tolerances alone: misfit %.3g', first.misfit)
    return take_out_second_order(replace(search, current=first))


def seek_lines(search: Search) -> Search:
    """Look for hums and gear orders in what is left over, once the model is not far off."""
    current = search.fitted
    if current.misfit > LIMITS.near_misfit:
        log.debug('misfit %.3g: too far off to look for lines', current.misfit)
        return search
    fitting, hypothesis = search.data.fitting, current.hypothesis
    known = search.scene.lines_hz
    lines = lines_left(fitting, hypothesis, search.settings.band, known)
    ripples = orders_left(hypothesis, fitting, search.scene.flexible_joints)
    log.debug('lines at %s Hz, %d gear orders', list(lines), len(ripples))
    scene = replace(search.scene, lines_hz=lines, ripples=ripples)
    hypothesis = replace(hypothesis, scene=scene)
    search = replace(search, scene=scene, current=replace(current, hypothesis=hypothesis))
    if lines == known:
        return search
    search = search.with_data_about(hypothesis.cell())
    again = fit(hypothesis, search.data.fitting, relinearise=0)
    return replace(search, current=again.without_columns)


def seek_hanging(search: Search) -> Search:
    """Look where a mass that swings would explain most."""
    if not any(kind.hangs for kind in search.settings.catalogue):
        return search
    current = search.fitted
    # There the best are followed from, too, however far tolerances are distorted.
    scene = replace(search.scene, hanging=hanging(current.hypothesis, search.data.loudest))
    hypothesis = replace(current.hypothesis, scene=scene)
    return replace(search, scene=scene, current=replace(current, hypothesis=hypothesis))


def screen_catalogue(search: Search) -> Search:
    """Try every effect of the catalogue coarsely, those that could explain something."""
    current, base = search.fitted, search.fitted.hypothesis
    predictor = search.data.screening
    candidates = [
        effect
        for kind in search.settings.catalogue
        if kind.special_case not in {other.type for other in search.settings.catalogue}
        for effect in kind.instances(search.scene)
        if not any(same(effect, item) for item in base.effects)
    ]
    poor = current.misfit > LIMITS.distorted_misfit
    if poor or not search.stretched:
        bases = [base] if base.effects or not poor else [base, search.unstretched]
        base = bases[-1]
    else:  # tolerances hide what there is to reach: all of it where they leave nothing else
        bases = [search.relaxed] if current.misfit <= LIMITS.open_misfit else []
    if bases:
        candidates = within_reach(
            candidates, bases, predictor, LIMITS.least_reach_gain, LIMITS.least_reach_share
        )
    projection = Projection.of(base, predictor, tolerance_columns(base, predictor))
    return replace(search, trials=tuple(screen(candidates, projection, predictor)))


def screen_again(search: Search) -> Search:
    """Screen jointly with the tolerances where no trial promises to close the gap."""
    current, trials = search.fitted, search.trials
    closed = bool(trials) and trials[0].gain > LIMITS.closed_share * evidence_bound(current)
    little_left = current.misfit <= LIMITS.open_misfit
    if not search.stretched and (little_left or closed):
        return search
    # Where stretched tolerances leave nothing else, what there is to reach is what they hide.
    at = search.relaxed if little_left else current.hypothesis
    again = screen_jointly(trials, current.hypothesis, search.data.loudest, at)
    return replace(search, trials=tuple(again))


def fit_roughly(search: Search) -> Search:
    """Fit what promises most on coarse records, where that is worth it."""
    current = search.fitted
    if not _promising(search):
        best = [f'{trial.effect!r}: {trial.gain:.3g}' for trial in search.trials[:1]]
        log.debug('nothing promises enough (best %s)', *best or ['none'])
        return replace(search, fits=())
    rough = rough_fits(search)
    if rough and current.misfit > LIMITS.distorted_misfit and not search.simulated:
        about = replace(rough[0].hypothesis, held=()).cell()
        search = search.with_data_about(about)
    return replace(search, fits=tuple(rough))


def _promising(search: Search) -> bool:
    hypothesis = search.fitted.hypothesis
    first, further = LIMITS.least_promise, LIMITS.least_further_promise
    least = (further if hypothesis.effects else first) * search.settings.worth_adding
    best: tuple[Trial, ...] = search.trials[:1]
    return search.stretched or any(trial.gain >= least for trial in best)


def fit_finely(search: Search) -> Search:
    """Fit the closest on all records."""
    fine = fine_fits(search)
    return replace(search, fits=tuple(generalised(fine, search.settings.catalogue, search.data)))


def fit_again_without(search: Search) -> Search:
    """Fit the hypothesis without a new effect once more, from where the best with one has come to.

    What a candidate gains by tolerances that were fitted farther is no gain of its effect.
    """
    best = max(search.fits, key=lambda item: item.log_evidence, default=None)
    current = search.fitted
    if best is None or best.log_evidence - current.log_evidence < search.settings.worth_adding:
        return search
    without = best.hypothesis.without(len(best.hypothesis.effects) - 1)
    again = fit(without, search.data.fitting, iterations=5)
    if again.log_evidence <= current.log_evidence:
        return search
    log.debug('without: %.4g of log evidence more', again.log_evidence - current.log_evidence)
    return replace(search, current=again.without_columns)


def close_round(search: Search) -> Search:
    """Keep what the round found; the search ends where nothing earns a place."""
    current = search.fitted
    done = Round(
        before=current,
        heldout_before=search.heldout_misfit(current.hypothesis),
        candidates=search.candidates(search.fits),
        trials=search.trials,
    )
    number = len(search.rounds) + 1
    for item in done.candidates:
        log.debug('round %d: %r gains %.4g', number, item.effect, item.gain)
    earned = done.earns_place(search.settings.worth_adding)
    if not earned:
        log.debug('round %d: nothing gains enough to be added', number)
    return replace(search, rounds=(*search.rounds, done), trials=(), fits=(), finished=not earned)


def settle_best(search: Search) -> Search:
    """Fit the best candidate to the end; drop earlier effects that no longer earn a place."""
    done, fitting = search.rounds[-1], search.data.fitting
    best = done.candidates[0]
    last = fit(best.fit.hypothesis, fitting, iterations=4)
    number = 0
    while number < len(last.hypothesis.effects) - 1:
        fewer = last.hypothesis.without(number)
        again = fit(fewer, fitting, iterations=5, relinearise=0)
        lost = last.log_evidence - again.log_evidence
        if lost < search.settings.worth_adding:
            dropped = last.hypothesis.effects[number]
            log.debug('%r dropped: without it %.3g of log evidence are lost', dropped, lost)
            last = again
        else:
            number += 1
    gain = search.gain(last, done.before)
    return replace(search, current=last).with_best(replace(best, fit=last, gain=gain))


def take_out_second_order(search: Search) -> Search:
    """Fit again with the second-order motion of what was found out of the recordings.

    A linear simulation has none, and does not hang in its springs: what explains the recordings
    better is kept, once the gap is small enough to tell.
    """
    fitted = search.fitted
    distorted = fitted.misfit > LIMITS.distorted_misfit
    if search.simulated or (distorted and not fitted.hypothesis.effects):
        return replace(search, current=fitted.without_columns)
    again = partial(fit, fitted.hypothesis, linearised=fitted.linearised, iterations=4)
    moving = search.with_data_about(fitted.hypothesis.cell())
    found: Fit = again(predictor=moving.data.fitting)
    if search.simulated is None:
        linear = search.with_data_about(None)
        other: Fit = again(predictor=linear.data.fitting)
        if min(other.misfit, found.misfit) < REFINEMENT.settled_misfit:
            simulated = other.log_evidence > found.log_evidence + LIMITS.linear_lead
            log.debug('recordings of a linear simulation: %s', simulated)
            if simulated:
                return replace(linear, simulated=True, current=other.without_columns)
            moving = replace(moving, simulated=False)
    return replace(moving, current=found.without_columns)


def confirm_best(search: Search) -> Search:
    """Keep the settled fit of the best candidate, and how it does on held-out records."""
    last, best = search.fitted, search.rounds[-1].candidates[0]
    misfit = search.heldout_misfit(last.hypothesis)
    return search.with_best(replace(best, fit=last, heldout_misfit=misfit))


def stop_or_go_on(search: Search) -> Search:
    """End the search where a further effect has nothing left to gain."""
    bound = evidence_bound(search.fitted) + tolerance_excess(search.fitted)
    log.debug('misfit %.3g, evidence bound %.3g', search.fitted.misfit, bound)
    return replace(search, finished=bound < search.settings.worth_adding)
