"""From what promised most to fitted explanations: roughly first, the closest on all records."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
import logging

import numpy as np

from model_gap.effects import Effect, same
from model_gap.fit import Fit, fit, fits, Linearised, tolerance_columns
from model_gap.hypothesis import Hypothesis, instead_of_tolerances, more_general
from model_gap.predict import Predictor
from model_gap.search.elsewhere import elsewhere
from model_gap.search.evidence_bound import evidence_bound, least_further_gain
from model_gap.search.reach import within_reach
from model_gap.search.rivals import EVIDENCE_BETWEEN
from model_gap.search.screen import Projection, screen, Trial
from model_gap.search.search import Search
from model_gap.search.search_data import SearchData

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class RefinementLimits:
    """What is fitted, roughly and on all records.

    Parameters
    ----------
    rough, rough_per_type, rough_per_place : int
        Most rough fits of a round, of one type of effect, of one type at one place.
    rough_after_torques : int
        Most rough fits beside an accepted torque law, where a fit takes longer.
    refined : int
        Most fits on all records.
    least_promise : float
        What promised less than this share of the best in the screening is not tried.
    hopeless : float
        Rough fits whose log evidence is this far behind the best are not refined.
    settled_misfit, settled_share : float
        Once a rough fit is this good, torque laws in other joints that promised less than this
        share are not tried.  Those in the joint of the best are: laws mimic each other.
    mimicked_misfit : float
        Tolerances mimic an effect only where they leave little; where much is left they are
        distorted.  Of a model known roughly they are so with whatever is left.
    instead : int
        Most effects that are tried instead of stretched tolerances together.
    instead_share : float
        These only where a free force would explain this share of what one does at the best place.
    linearisations, linearisations_far : int
        Of the tolerances in a rough fit, at most; of a model known roughly the way is long.
    detailed : float
        Details are looked into of candidates this close to the best, in log evidence.
    """

    rough: int = 8
    rough_per_type: int = 4
    rough_per_place: int = 2
    rough_after_torques: int = 4
    refined: int = 4
    least_promise: float = 0.06
    hopeless: float = 200.0
    settled_misfit: float = 1.5
    settled_share: float = 0.5
    mimicked_misfit: float = 4.0
    instead: int = 3
    instead_share: float = 0.4
    linearisations: int = 3
    linearisations_far: int = 12
    detailed: float = 100.0


REFINEMENT = RefinementLimits()


def rough_fits(search: Search) -> list[Fit]:
    """Fit what promised most on the coarse records; return those worth more, the best first."""
    current, coarse, catalogue = search.fitted, search.data.coarse, search.settings.catalogue
    held = coarse.hold(current.hypothesis.cell()).held
    trials = chosen(search.trials)[: REFINEMENT.rough_after_torques if held else None]
    found: list[Fit | None] = []
    known_roughly = search.roughly_known is not None
    often = REFINEMENT.linearisations_far if known_roughly else REFINEMENT.linearisations
    starts = [replace(_freed(item), held=held) for item in _mimicked(search)]
    found += fits(lambda start: fit(start, coarse, relinearise=often), starts)
    shared = Linearised.of(trials[0].base, coarse) if trials else None

    def begin(start: Hypothesis) -> Fit:
        return fit(start, coarse, shared, _rough_steps(start), relinearise=0)

    def go_on(start: Hypothesis) -> Fit:
        most = REFINEMENT.linearisations if start.effects[-1].amplitude_dependent else often
        return fit(start, coarse, None, _rough_steps(start), relinearise=most - 1)

    def roughly(starts: Sequence[Hypothesis]) -> list[Fit | None]:
        begun = [item for item in fits(begin, starts) if item]
        least = _least_to_go_on(begun)
        behind = [item for item in begun if item.log_evidence < least]
        ahead = [item.hypothesis for item in begun if item.log_evidence >= least]
        return [*fits(go_on, ahead), *behind]

    def starts_of(some: Sequence[Trial]) -> list[Hypothesis]:
        return [
            replace(trial.base, held=held).with_effect(trial.effect, values)
            for trial in some
            for values in dict.fromkeys((trial.values, *others_of(trial)))
        ]

    def others_of(trial: Trial) -> Sequence[tuple[float, ...]]:
        near = trial.gain >= REFINEMENT.settled_share * trials[0].gain
        return trial.effect.other_starts(trial.values) if near else ()

    def may_wait(trial: Trial) -> bool:
        promises = trial.gain >= REFINEMENT.settled_share * trials[0].gain
        other_place = trial.effect.location != trials[0].effect.location
        return trial.effect.amplitude_dependent and other_place and not promises

    found += roughly(starts_of([trial for trial in trials if not may_wait(trial)]))
    if min((item.misfit for item in found if item), default=np.inf) > REFINEMENT.settled_misfit:
        found += roughly(starts_of([trial for trial in trials if may_wait(trial)]))
    found += roughly(_general_starts(best_of_each(found), catalogue))
    found += roughly(_simpler_starts(best_of_each(found)))
    close = best_of_each(found)
    for item in close[REFINEMENT.refined :]:
        _log_dropped(item, close[0], f'{REFINEMENT.refined} others are closer')
    close = close[: REFINEMENT.refined]
    if close and close[0].misfit > REFINEMENT.settled_misfit:
        close = best_of_each(with_details(close, coarse))
    least = close[0].log_evidence - REFINEMENT.hopeless if close else 0.0
    for item in close:
        if item.log_evidence <= least:
            _log_dropped(item, close[0], 'hopelessly behind')
    return [item for item in close if item.log_evidence > least]


def _rough_steps(start: Hypothesis) -> int:
    return 4 if start.effects[-1].amplitude_dependent else 6


def _least_to_go_on(begun: Sequence[Fit]) -> float:
    """Return the log evidence from which on a fit is taken further.

    Derivatives of a torque cost as much as all its steps: they are worked out anew of those that
    may be refined, not of those hopelessly behind.
    """
    best = [item.log_evidence for item in best_of_each(begun)]
    return min(best[: REFINEMENT.refined][-1], best[0] - REFINEMENT.hopeless) if best else 0.0


def _mimicked(search: Search) -> list[Hypothesis]:
    """Return starts with what stretched tolerances may stand for, one by one and together."""
    current, catalogue = search.fitted, search.settings.catalogue
    hypothesis, little_left = current.hypothesis, current.misfit < REFINEMENT.mimicked_misfit
    found: list[Hypothesis] = []
    if little_left or search.roughly_known is not None:
        found += instead_of_tolerances(
            hypothesis, search.unstretched, catalogue, search.stretched_from
        )
    if little_left and search.stretched:
        found += _instead_of_many(search)
    return found


def _freed(start: Hypothesis) -> Hypothesis:
    """Return a start with its last effect's details free, where it has any.

    Held where no one knows them they lead astray as tolerances held at nominal do: a mass that
    hangs elsewhere ends as another one, swinging at another frequency.
    """
    return start.with_details() or start


def _instead_of_many(search: Search) -> list[Hypothesis]:
    """Return starts with what explains most where tolerances are as they were before any fit.

    What many of them together have made up for gains nothing from where they are.
    """
    before, predictor = search.relaxed, search.data.screening
    effects = [trial.effect for trial in search.trials]
    near = within_reach(effects, [before], predictor, 0.0, REFINEMENT.instead_share)
    projection = Projection.of(before, predictor, tolerance_columns(before, predictor))
    trials = screen(near, projection, predictor)
    return [
        before.with_effect(trial.effect, trial.values) for trial in trials[: REFINEMENT.instead]
    ]


def _log_dropped(item: Fit, best: Fit, why: str) -> None:
    log.debug(
        '%r dropped: %s, the best by %.3g of log evidence',
        item.hypothesis.effects[-1],
        why,
        best.log_evidence - item.log_evidence,
    )


def _general_starts(found: Sequence[Fit], catalogue: Sequence[type[Effect]]) -> list[Hypothesis]:
    """Return starts of the laws whose special case leaves much over, where the best fit is.

    Far behind another name it would be dropped before what it stands for is tried.
    """
    if not found:
        return []
    best = found[0]
    # Where the best leaves nothing to gain, what does not come near it is no rival either.
    nothing_left = evidence_bound(best) < EVIDENCE_BETWEEN
    least = best.log_evidence - REFINEMENT.hopeless if nothing_left else -np.inf
    for item in found:
        if item.hypothesis.effects[-1].location == best.hypothesis.effects[-1].location:
            starts = more_general(item.hypothesis, catalogue)
            if starts:
                much_left = item.misfit > REFINEMENT.settled_misfit
                return starts if much_left and item.log_evidence > least else []
    return []


def _simpler_starts(found: Sequence[Fit]) -> list[Hypothesis]:
    """Return starts of what is simpler than the closest fits, from where these are.

    More numbers come near from farther away: a mass that swings at the end of its range stood for
    one that does not, which a fit of few steps had not reached.
    """
    starts: list[Hypothesis] = []
    for item in found[: REFINEMENT.refined]:
        last = len(item.hypothesis.effects) - 1
        simpler = item.hypothesis.effects[last].simpler(
            item.hypothesis.values()[last], item.hypothesis.scene
        )
        if simpler and not any(same(simpler[0], start.effects[-1]) for start in starts):
            starts.append(item.hypothesis.without(last).with_effect(*simpler))
    return starts


def fine_fits(search: Search) -> list[Fit]:
    """Fit on all records; the best also with their details free, and at all other places."""
    rough, data = search.fits, search.data
    starts = [replace(item.hypothesis, held=()) for item in rough]
    slow = [start for start in starts if _steps_torques(start)]
    quick = [start for start in starts if not _steps_torques(start)]
    # Apart: a single slow one shares its own work among the processors.
    found = [item for some in (quick, slow) for item in _finely(some, data) if item]
    best = max((item.log_evidence for item in found), default=0.0)
    near = [item for item in found if item.log_evidence > best - REFINEMENT.detailed]
    rest = [item for item in found if item.log_evidence <= best - REFINEMENT.detailed]
    near = with_details(near, data.fitting)
    return best_of_each([*near, *_elsewhere(near, search), *rest])


def _finely(
    starts: Sequence[Hypothesis], data: SearchData, relinearise: int = 0
) -> list[Fit | None]:
    def finely(start: Hypothesis) -> Fit:
        iterations = 3 if _steps_torques(start) else 5
        return fit(start, data.fitting, iterations=iterations, relinearise=relinearise)

    return fits(finely, starts)


def _steps_torques(hypothesis: Hypothesis) -> bool:
    return any(effect.amplitude_dependent for effect in hypothesis.effects)


def _elsewhere(near: Sequence[Fit], search: Search) -> list[Fit]:
    """Fit the best effect at all other places, and from a better one on until it stays."""
    without, data = search.fitted, search.data
    worth = max(search.settings.worth_adding, least_further_gain(without))
    found: list[Fit] = []
    best = max(near, key=lambda item: item.log_evidence, default=None)
    left: set[tuple[str | None, str]] = set()
    while best is not None and search.gain(best, without) >= worth:
        left.add(_place(best.hypothesis))
        moved = [
            start
            for start in elsewhere(best.hypothesis, without.hypothesis, data.coarse)
            if _place(start) not in left
        ]
        fine = _finely(moved, data, relinearise=1)
        beside = with_details([item for item in fine if item], data.fitting)
        found += beside
        least = best.log_evidence
        better = [item for item in beside if item.log_evidence > least]
        best = max(better, key=lambda item: item.log_evidence, default=None)
    return found


def _place(hypothesis: Hypothesis) -> tuple[str | None, str]:
    return hypothesis.effects[-1].location, hypothesis.effects[-1].variant


def with_details(found: Sequence[Fit], predictor: Predictor) -> list[Fit]:
    """Return each fit with its last effect's details free, where it has any.

    No one knows them: values, deviations and evidence must contain that.
    """
    starts = {
        n: start for n, item in enumerate(found) if (start := item.hypothesis.with_details())
    }
    freed = fits(
        lambda start: fit(start, predictor, iterations=5, relinearise=2), list(starts.values())
    )
    detailed = dict(zip(starts, freed, strict=True))
    return [detailed.get(number) or item for number, item in enumerate(found)]


def chosen(trials: Sequence[Trial]) -> list[Trial]:
    """Return the trials worth a refined fit: the best, not too many of one type and place."""
    found: list[Trial] = []
    for trial in trials:
        if any(same(trial.effect, item.effect) for item in found):
            continue  # only begun otherwise
        alike = sum(item.effect.type == trial.effect.type for item in found)
        here = sum(item.effect.key == trial.effect.key for item in found)
        promising = trial.gain > max(1.0, REFINEMENT.least_promise * trials[0].gain)
        if alike < REFINEMENT.rough_per_type and here < REFINEMENT.rough_per_place and promising:
            found.append(trial)
        elif not promising:
            log.debug('%r not fitted: promises only %.3g', trial.effect, trial.gain)
        else:
            log.debug(
                '%r not fitted: %d of its type and %d of its place are', trial.effect, alike, here
            )
        if len(found) == REFINEMENT.rough:
            break
    return found


def best_of_each(candidates: Sequence[Fit | None]) -> list[Fit]:
    """Return the best fit of every effect, the best first: several starts may have met."""
    found: list[Fit] = []
    for item in sorted((item for item in candidates if item), key=lambda item: -item.log_evidence):
        last = item.hypothesis.effects[-1]
        if not any(same(last, other.hypothesis.effects[-1]) for other in found):
            found.append(item)
    return found
