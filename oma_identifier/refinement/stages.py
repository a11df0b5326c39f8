"""The stages of a refinement, each modes in, modes out."""

from collections.abc import Callable
from dataclasses import replace
import logging

from oma_identifier.likelihood import (
    BandIndex,
    fit_known,
    fit_with_residuals,
    group_modes,
    GroupFit,
    ModeIndex,
    StartModes,
    updated,
)
from oma_identifier.refinement.acceptance import accept, differ, improves, Outcome, overlap, TAKEN
from oma_identifier.refinement.completion import add_candidates, add_missing, demanded
from oma_identifier.refinement.direct_motion import in_step, shares_force
from oma_identifier.refinement.label_switching import undo_label_switching
from oma_identifier.refinement.mode_evidence import is_demanded, superfluous
from oma_identifier.refinement.narrow_force import alone, narrow_forces
from oma_identifier.refinement.refining import Refining
from oma_identifier.refinement.thresholds import REFINEMENT

PASSES = 2
"""The second pass has refined tails and shapes to project out."""

Stage = Callable[[Refining], Refining]
log = logging.getLogger(__name__)


def fit_groups(of: Refining) -> Refining:
    """Fit every group of modes that overlap, from where they are."""
    groups = group_modes(of.now, of.record.spectra.spacing_hz)
    if of.warm is None:
        fits = of.fitter.fit(of.now, groups)
    else:
        fits = of.fitter.fit(of.now, groups, begin=of.warm.begin)
    return replace(of, fits=tuple(fits))


def leave_out_superfluous(of: Refining) -> Refining:
    """Begin anew without a mode that is another one once more, as long as there is one."""
    while (mode := _superfluous(of)) is not None:
        twice = of.given[mode]
        log.debug('%.4g Hz: superfluous', of.given_mode(mode).frequency_hz)
        rest = [index for index in of.given if index != twice]
        outcomes = {**of.outcomes, twice: Outcome.SUPERFLUOUS}
        of = fit_groups(Refining.begin(of.record, rest, outcomes))
    return of


def _superfluous(of: Refining) -> ModeIndex | None:
    for each in of.fits:
        if (position := superfluous(each)) is not None:
            return each.group[position]
    return None


def fit_again(of: Refining) -> Refining:
    """Fit the same groups with the refined tails and shapes of the others.

    One pass less where the start was refined before.
    """
    now, fits = updated(of.now, of.fits), list(of.fits)
    for _ in range(1, PASSES - (of.warm is not None)):
        now, fits = of.fitter.again(now, fits)
    return replace(of, now=now, fits=tuple(fits))


def take_in_missing(of: Refining) -> Refining:
    """Add modes that were not given, as long as that mends the bands that lack one."""
    before = of
    of = add_missing(add_candidates(of))
    if of is not before:
        now, fits = of.fitter.again(of.now, of.fits)
        now, fits = undo_label_switching(now, fits, of.start)
        of = replace(of, now=now, fits=tuple(fits))
    added = demanded(of)
    return replace(of, added=added) if added else before


def decide(of: Refining) -> Refining:
    """Accept each mode that was refined, or say why not."""
    outcomes = dict(of.outcomes)
    for each in of.fits:
        bent = _bent(of, each)
        for position, mode in each.members():
            if mode >= of.n_given:
                continue
            split = any(overlap(of.now, mode, other) for other in of.added)
            if not of.idle.isdisjoint(each.group):
                outcome = Outcome.NOT_TRIED
            elif position in bent or _in_step(of, each, position):
                outcome = Outcome.MODEL_MISFIT
            elif split and is_demanded(each, position):
                outcome = Outcome.SPLIT
            else:
                outcome = accept(each, position)
            outcomes[of.given[mode]] = outcome
            log.debug(
                '%.4g Hz: %s, misfit %.3g',
                of.given_mode(mode).frequency_hz,
                outcome.value,
                each.misfit,
            )
    return replace(of, outcomes=outcomes)


def _bent(of: Refining, each: GroupFit) -> list[BandIndex]:
    """Return the modes of a fit that come out elsewhere once forces may do more than drive modes.

    Few forces bend a bell by what modes that nobody found do beside it (Hausman 1978).
    """
    if each.fit is None or each.band is None:
        return []
    fit, data = each.fit, each.band.data
    sharing = [p for p, _ in each.members() if shares_force(data, fit.model, p)]
    if not sharing or not fit.converged or each.misfit > REFINEMENT.adopted_misfit:
        return []
    record = of.record
    wider = fit_with_residuals(record.spectra, of.now, each.group, record.usable)
    if wider.fit is None or not wider.misfit < REFINEMENT.incomplete_misfit:
        return []
    return [p for p in sharing if differ(fit, wider.fit, p)]


def _in_step(of: Refining, each: GroupFit, position: BandIndex) -> bool:
    if not of.record.is_whole or each.fit is None:
        return False
    added = [at for at, mode in each.members() if mode >= of.n_given]
    return in_step(each.fit.model, position, added)


def _overlapping(of: Refining, mode: ModeIndex) -> list[ModeIndex]:
    """Return the modes found missing that overlap with one that was given."""
    new = [other for other in of.now.indices() if other >= of.n_given]
    return [other for other in new if overlap(of.now, mode, other)]


def with_known_motion(of: Refining) -> Refining:
    """Replace fits by those with known inputs, where these are better and agree.

    With inputs that are wrong the fit is another one than without (Hausman 1978): where that may
    be, or where the inputs explain nothing, everything stays.
    """
    if of.record.inputs is None:
        return of
    now, found = of.now, dict(enumerate(of.fits))
    for _ in range(PASSES):
        fitted = {place: _with_inputs(of, now, each) for place, each in found.items()}
        found = {place: each for place, each in fitted.items() if each is not None}
        now = updated(now, list(found.values()))
    known = {place: each for place, each in found.items() if _is_better(of, of.fits[place], each)}
    if not known:
        return of
    fits = [known.get(place, each) for place, each in enumerate(of.fits)]
    of_mode = {mode: each for each in known.values() for mode in each.group}
    added = {mode: of_mode.get(mode, each) for mode, each in of.added.items()}
    outcomes = dict(of.outcomes)
    for mode in of_mode:
        if mode < of.n_given and outcomes[of.given[mode]] not in TAKEN:
            outcomes[of.given[mode]] = Outcome.REFINED
    now = updated(of.now, list(known.values()))
    return replace(of, fits=tuple(fits), added=added, outcomes=outcomes, now=now)


def _with_inputs(of: Refining, now: StartModes, each: GroupFit) -> GroupFit | None:
    if of.record.inputs is None or not of.idle.isdisjoint(each.group):
        return None
    return fit_known(of.record.spectra, now, each, of.record.inputs)


def _is_better(of: Refining, plain: GroupFit, known: GroupFit) -> bool:
    beside = [other for mode in known.group for other in _overlapping(of, mode)]
    if not set(beside) <= set(known.group) or not improves(plain, known):
        return False
    return all(
        accept(known, position) is Outcome.REFINED
        for position, mode in known.members()
        if mode < of.n_given
    )


def tell_narrow_forces(of: Refining) -> Refining:
    """Leave out peaks that end as no resonance does; their fits describe the force.

    Known inputs may have such bands.  A mode that moves ends as well where it is followed for
    long: what windows show in turn tells it, so that these list it.
    """
    if not of.record.is_whole:
        return of
    plain = [each for each in of.fits if each.without is None]
    found, outcomes = narrow_forces(plain), dict(of.outcomes)
    none = alone(found)
    for mode in none:
        log.debug('%.4g Hz: ends as no resonance does', found[mode].frequency_hz)
        if mode < of.n_given and outcomes[of.given[mode]] is not Outcome.NOT_TRIED:
            outcomes[of.given[mode]] = Outcome.NARROW_FORCE
    added = {mode: each for mode, each in of.added.items() if mode not in none}
    return replace(of, added=added, outcomes=outcomes, narrow=tuple(found.values()))


STAGES: tuple[Stage, ...] = (
    fit_groups,
    leave_out_superfluous,
    fit_again,
    take_in_missing,
    decide,
    with_known_motion,
    tell_narrow_forces,
)
