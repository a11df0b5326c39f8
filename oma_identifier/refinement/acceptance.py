"""Acceptance test of a refined mode: what became of it, and why."""

from enum import StrEnum
import math

import numpy as np

from modal_core.indicators import mac_of_span
from modal_core.mode import Mode
from oma_identifier.likelihood import BandIndex, GroupFit, ModeIndex, overlaps, StartModes
from oma_identifier.refinement.direct_motion import moves_with_force
from oma_identifier.refinement.thresholds import REFINEMENT


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
    FAR_FROM_START = 'far_from_start'
    MODEL_MISFIT = 'model_misfit'
    NOT_TRIED = 'not_tried'


TAKEN = (Outcome.REFINED, Outcome.SPLIT)
"""Of modes that a refinement gives."""


def accept(
    each: GroupFit,
    position: BandIndex,
    given: Mode,
    start: StartModes,
    mode: ModeIndex,
    duration_s: float,
) -> Outcome:
    """Test a mode that was fitted.

    Parameters
    ----------
    each : GroupFit
        Of its band.
    position : BandIndex
        Of the mode in the fit.
    given : Mode
        As it came.
    start : StartModes
        All modes as they came.
    mode : ModeIndex
        Position of the mode there.
    duration_s : float [s]
        Length of the record.
    """
    if each.fit is None or each.band is None:
        return Outcome.TOO_SHORT
    if not each.fit.converged:
        return Outcome.NOT_CONVERGED
    if each.coarse or not each.fit.misfit < REFINEMENT.accepted_misfit:
        return Outcome.MODEL_MISFIT
    model = each.fit.model
    if moves_with_force(each.band.data, model, position):
        return Outcome.MODEL_MISFIT
    frequency, damping = model.frequency_hz[position], model.damping_ratio[position]
    law = math.sqrt(damping / (2.0 * math.pi * frequency * duration_s))
    frequency_std = _known(given.frequency_std_hz, 1.5 * law * frequency)
    damping_std = _known(given.damping_ratio_std, 1.5 * law)  # σ_ζ = sqrt(ζ/(2πfT)) is the same
    f_reach = REFINEMENT.far_std * math.hypot(
        frequency_std, each.fit.frequency_std[position] * frequency
    )
    d_reach = REFINEMENT.far_std * math.hypot(
        damping_std, each.fit.damping_ratio_std[position] * damping
    )
    wide = REFINEMENT.far_half_widths * damping
    far = abs(frequency - given.frequency_hz) > max(f_reach, wide * frequency)
    far |= abs(damping - given.damping_ratio) > max(d_reach, wide)
    # Modes that overlap may be mixed at the start, so the shape may turn towards its neighbours'.
    n_listed = len(start.frequency_hz)
    near = [other for other in each.group if other < n_listed and overlap(start, mode, other)]
    before = each.band.project.T @ start.shapes[:, near]
    far |= mac_of_span(model.shapes[:, position], before) < REFINEMENT.kept_mac
    return Outcome.FAR_FROM_START if far else Outcome.REFINED


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
    steps, spreads, first, second = [], [], plain.fit, known.fit
    for name in ('frequency', 'damping_ratio'):
        before, after = getattr(first, f'{name}_std'), getattr(second, f'{name}_std')
        own = slice(0, first.model.n_free)
        values = [
            getattr(fit.model, name + '_hz' * (name == 'frequency'))[own]
            for fit in (first, second)
        ]
        if not np.all(after <= before):
            return False
        steps.append(np.log(values[1] / values[0]))
        spreads.append(np.sqrt(before**2 - after**2))
    holds = not plain.coarse and plain.misfit <= REFINEMENT.adopted_misfit
    return not holds or bool(np.all(np.abs(steps) <= REFINEMENT.differing_std * np.array(spreads)))


def overlap(start: StartModes, first: ModeIndex, second: ModeIndex) -> bool:
    """Tell whether the half-power bandwidths of two modes touch."""
    return bool(overlaps(start.frequency_hz, start.half_width_hz)[first, second])


def _known(value: float, otherwise: float) -> float:
    return max(value, otherwise) if math.isfinite(value) else otherwise
