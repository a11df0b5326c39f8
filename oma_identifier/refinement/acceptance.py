"""Acceptance test of a refined mode: what became of it, and why."""

from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from oma_identifier.likelihood import (
    BandFit,
    BandIndex,
    GroupFit,
    is_steep,
    ModeIndex,
    overlaps,
    StartModes,
)
from oma_identifier.refinement.direct_motion import moves_with_force
from oma_identifier.refinement.thresholds import REFINEMENT

Real = NDArray[np.float64]


class Outcome(StrEnum):
    """What became of one mode."""

    REFINED = 'refined'
    SPLIT = 'split'
    """Refined, and another mode was found that it stood for as well."""
    SUPERFLUOUS = 'superfluous'
    """Another mode once more: the data do without it."""
    OUT_OF_BAND = 'out_of_band'
    TOO_SHORT = 'too_short'
    NOT_CONVERGED = 'not_converged'
    MODEL_MISFIT = 'model_misfit'
    NARROW_FORCE = 'narrow_force'
    """A peak that ends as no resonance does."""
    NOT_TRIED = 'not_tried'


TAKEN = (Outcome.REFINED, Outcome.SPLIT)
"""Of modes that a refinement gives."""


def accept(each: GroupFit, position: BandIndex) -> Outcome:
    """Test a mode that was fitted.

    Parameters
    ----------
    each : GroupFit
        Of its band.
    position : BandIndex
        Of the mode in the fit.
    """
    if each.fit is None or each.band is None:
        return Outcome.TOO_SHORT
    if not each.fit.converged:
        return Outcome.NOT_CONVERGED
    if each.coarse or not each.fit.misfit < REFINEMENT.accepted_misfit:
        return Outcome.MODEL_MISFIT
    if is_steep(each.fit):
        # A force that ends within a band has no one slope there, and the misfit need not show it:
        # refined damping came out 10 to 20 % too small.
        return Outcome.MODEL_MISFIT
    if moves_with_force(each.band.data, each.fit.model, position):
        return Outcome.MODEL_MISFIT
    return Outcome.REFINED


def improves(plain: GroupFit, known: GroupFit) -> bool:
    """Tell whether a fit with known inputs may replace one without.

    It must describe the response to the inputs and be the more precise one, and where the other
    holds the two must agree (Hausman's test: an efficient against a consistent estimator).
    """
    if plain.fit is None or known.fit is None or known.band is None or known.band.motion is None:
        return False
    if known.band.motion.bends < REFINEMENT.known_chance:
        return False
    if not known.misfit <= REFINEMENT.adopted_misfit:
        return False
    (before, wide), (after, narrow) = _poles(plain.fit), _poles(known.fit)
    if not np.all(narrow <= wide):
        return False
    holds = not plain.coarse and plain.misfit <= REFINEMENT.adopted_misfit
    spread = np.sqrt(wide**2 - narrow**2)
    return not holds or bool(np.all(np.abs(after - before) <= REFINEMENT.differing_std * spread))


def differ(fit: BandFit, wider: BandFit, position: BandIndex) -> bool:
    """Tell whether a fit with fewer assumptions contradicts one of a mode (Hausman's test)."""
    (value, narrow), (other, wide) = _poles(fit), _poles(wider)
    more = np.sqrt(np.maximum(wide**2 - narrow**2, 0.0))
    spread = np.maximum(more, REFINEMENT.least_spread * narrow)
    agree = np.abs(other - value) < REFINEMENT.bent_std * spread
    return not agree[:, position].all()


def _poles(fit: BandFit) -> tuple[Real, Real]:
    """Return ln f and ln ζ of the free modes with their deviations, (2, n_free) each."""
    model, own = fit.model, slice(0, fit.model.n_free)
    values = np.log([model.frequency_hz[own], model.damping_ratio[own]])
    return np.asarray(values), np.array([fit.frequency_std, fit.damping_ratio_std])


def overlap(start: StartModes, first: ModeIndex, second: ModeIndex) -> bool:
    """Tell whether the half-power bandwidths of two modes touch."""
    return bool(overlaps(start.frequency_hz, start.half_width_hz)[first, second])
