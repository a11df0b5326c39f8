"""The stages of a refinement, each modes in, modes out."""

from collections.abc import Callable
from dataclasses import replace
import logging

from oma_identifier.likelihood import group_modes, ModeIndex, pooled_slopes, updated
from oma_identifier.refinement.acceptance import accept, Outcome, overlap
from oma_identifier.refinement.band_fitter import middle
from oma_identifier.refinement.completion import add_missing, demanded
from oma_identifier.refinement.label_switching import undo_label_switching
from oma_identifier.refinement.mode_evidence import is_demanded, superfluous
from oma_identifier.refinement.refining import Refining

PASSES = 2
"""The second pass has refined tails and shapes to project out."""

Stage = Callable[[Refining], Refining]
log = logging.getLogger(__name__)


def fit_groups(of: Refining) -> Refining:
    """Fit every group of modes that overlap, from where they are."""
    groups = group_modes(of.now)
    if of.warm is None or of.record.warm_start is None:
        fits = of.fitter.fit(of.now, groups)
    else:
        places = [middle(of.now, group) for group in groups]
        slopes = pooled_slopes(of.record.warm_start.slopes, places)
        fits = of.fitter.fit(of.now, groups, slopes, begin=of.warm.begin)
    return replace(of, fits=tuple(fits))


def leave_out_superfluous(of: Refining) -> Refining:
    """Begin anew without a mode that is another one once more, as long as there is one."""
    while (mode := _superfluous(of)) is not None:
        twice = of.given[mode]
        log.debug('%.4g Hz: superfluous', of.given_mode(mode).frequency_hz)
        rest = [index for index in of.given if index != twice]
        outcomes = {**of.outcomes, twice: Outcome.SUPERFLUOUS}
        if not rest:
            return replace(of, given=(), fits=(), outcomes=outcomes)
        of = fit_groups(Refining.begin(of.record, rest, outcomes))
    return of


def _superfluous(of: Refining) -> ModeIndex | None:
    for each in of.fits:
        if (position := superfluous(each)) is not None:
            mode = each.group[position]
            return mode if mode < of.n_given else None
    return None


def fit_again(of: Refining) -> Refining:
    """Fit the same groups with the refined tails, shapes and slopes of the others.

    One pass more where modes were missing, one less where the start was refined before.
    """
    if not of.fits:
        return of
    now, fits = updated(of.now, of.fits), list(of.fits)
    n_passes = PASSES - (of.warm is not None) + (len(now.frequency_hz) > of.n_given)
    for _ in range(1, n_passes):
        now, fits = of.fitter.again(now, fits)
    return replace(of, now=now, fits=tuple(fits))


def take_in_missing(of: Refining) -> Refining:
    """Add modes that were not given, as long as that mends the bands that lack one."""
    before = of
    of = add_missing(of)
    if of is not before:
        now, fits = of.fitter.again(of.now, of.fits)
        now, fits = undo_label_switching(now, fits, of.start)
        of = replace(of, now=now, fits=tuple(fits))
    added = demanded(of)
    if not any(mode >= len(before.now.frequency_hz) for mode in added):
        return replace(before, added=demanded(before))
    return replace(of, added=added)


def decide(of: Refining) -> Refining:
    """Accept each mode that was refined, or say why not."""
    outcomes = dict(of.outcomes)
    for each in of.fits:
        for position, mode in each.members():
            if mode >= of.n_given:
                continue
            split = any(overlap(of.now, mode, other) for other in of.added)
            if not of.idle.isdisjoint(each.group):
                outcome = Outcome.NOT_TRIED
            elif split and is_demanded(each, position):
                outcome = Outcome.SPLIT
            else:
                outcome = accept(
                    each, position, of.given_mode(mode), of.start, mode, of.record.duration_s
                )
            outcomes[of.given[mode]] = outcome
            log.debug(
                '%.4g Hz: %s, misfit %.3g',
                of.given_mode(mode).frequency_hz,
                outcome.value,
                each.misfit,
            )
    return replace(of, outcomes=outcomes)


STAGES: tuple[Stage, ...] = (
    fit_groups,
    leave_out_superfluous,
    fit_again,
    take_in_missing,
    decide,
)
