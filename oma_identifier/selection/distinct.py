"""One pole for each mode, of those that make sense beside the others."""

import logging
import math

import numpy as np

from modal_core.numbers.indicators import mac
from oma_identifier.selection.selected_pole import SelectedPole
from oma_identifier.selection.thresholds import SELECTION

log = logging.getLogger(__name__)


def without_repeats(poles: list[SelectedPole]) -> list[SelectedPole]:
    """Return one pole per mode, the best determined, by frequency."""
    kept: list[SelectedPole] = []
    for pole in sorted(poles, key=_absolute_uncertainty):
        better = next((other for other in kept if is_same_mode(pole, other)), None)
        if better is None:
            kept.append(pole)
        else:
            log.debug(
                '%.4g Hz: the mode at %.4g Hz once more', pole.frequency_hz, better.frequency_hz
            )
    return sorted(kept, key=lambda pole: pole.frequency_hz)


def new_among(poles: list[SelectedPole], known: list[SelectedPole]) -> list[SelectedPole]:
    """Return one pole for each mode that is none of those known, by frequency."""
    return without_repeats(
        [pole for pole in poles if not any(is_same_mode(pole, other) for other in known)]
    )


def _absolute_uncertainty(pole: SelectedPole) -> float:
    return pole.deviation.frequency_std_hz / pole.frequency_hz


def is_same_mode(first: SelectedPole, second: SelectedPole) -> bool:
    """Tell whether two poles are views of one mode."""
    width = max(-first.pole.real, -second.pole.real)
    if abs(first.pole - second.pole) > SELECTION.same_distance * width:
        return False
    own = first.band.scale
    other = second.physical_shape * np.divide(1.0, own, out=np.zeros_like(own), where=own > 0.0)
    alike = bool(mac(first.shape, other)[0, 0] > SELECTION.same_mac)
    if first.band is not second.band:
        return alike
    # Two modes show up at the same model orders side by side; two views of one mode take turns.
    orders = first.band.poles.model_order
    shared = np.intersect1d(orders[first.cluster.members], orders[second.cluster.members])
    side_by_side = len(shared) > 0.5 * min(len(first.cluster), len(second.cluster))
    # Over one or two channels all shapes are alike.
    return not side_by_side or (alike and not _far_apart(first, second))


def _far_apart(first: SelectedPole, second: SelectedPole) -> bool:
    """Tell whether frequencies or damping ratios differ by far more than they scatter."""
    frequency_hz = abs(first.frequency_hz - second.frequency_hz)
    ratio = abs(first.damping_ratio - second.damping_ratio)
    one, other = first.deviation, second.deviation
    frequency_std_hz = math.hypot(one.frequency_std_hz, other.frequency_std_hz)
    ratio_std = math.hypot(one.damping_ratio_std, other.damping_ratio_std)
    most = SELECTION.same_std
    return frequency_hz > most * frequency_std_hz or ratio > most * ratio_std


def beside_others(poles: list[SelectedPole]) -> list[SelectedPole]:
    """Return the poles that make sense beside the others.

    A doubtful pole of a complex shape needs a neighbour that it is mixed with; shafts that turn
    have such shapes by nature.  And the peak that speaks for a doubtful pole must be its own, not
    that of a narrower mode inside it that moves alike.
    """
    kept = []
    for pole in poles:
        doubtful = pole.from_limit >= SELECTION.doubtful
        if doubtful and pole.has_complex_shape and not _near(pole, poles, SELECTION.close):
            log.debug('%.4g Hz: a complex shape, and no neighbour to mix with', pole.frequency_hz)
        elif doubtful and _near(pole, _inside(pole, poles), 1.0):
            log.debug('%.4g Hz: doubtful, around a narrower mode', pole.frequency_hz)
        else:
            kept.append(pole)
    return kept


def _inside(pole: SelectedPole, poles: list[SelectedPole]) -> list[SelectedPole]:
    """Return the narrower poles of which too little is left in the shape of another."""
    return [
        other
        for other in poles
        if other.pole.real > pole.pole.real
        and 1.0 - float(mac(pole.shape, other.shape)[0, 0]) < SELECTION.least_filtered
    ]


def _near(pole: SelectedPole, poles: list[SelectedPole], reach: float) -> bool:
    """Tell whether there is another mode within half-power half-widths, of the wider."""
    return any(
        abs(pole.pole - other.pole) < reach * -min(pole.pole.real, other.pole.real)
        for other in poles
        if other is not pole
    )
