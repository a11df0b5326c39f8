"""Poles that stand for several modes, and those of canonical variates that tell these apart.

Where modes overlap, a pole may be none of them: at an order too low for all, one pole takes the
place of two, its shape a mixture of theirs, and the data determine it well.  Another weighting of
the same covariances that tells them apart shows it.
"""

from collections.abc import Sequence
import logging

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from modal_core.numbers.indicators import mac
from oma_identifier.likelihood import overlaps
from oma_identifier.selection.distinct import is_same_mode
from oma_identifier.selection.selected_pole import SelectedPole
from oma_identifier.selection.thresholds import SELECTION

log = logging.getLogger(__name__)
Poles = Sequence[SelectedPole]


def told_apart(plain: Poles, canonical: Poles) -> tuple[Poles, Poles]:
    """Return which poles stay, and which of canonical variates stand in for the others.

    Parameters
    ----------
    plain, canonical : sequence of SelectedPole
        Of one band, by the two factorisations.
    """
    stay, instead = list(plain), []
    for group in _touching([*plain, *canonical]):
        old = [pole for pole in plain if pole in group]
        new = [pole for pole in canonical if pole in group and _is_own(pole, canonical)]
        mixed = [pole for pole in old if _is_mixture(pole, new)]
        extra = [pole for pole in new if not any(is_same_mode(pole, other) for other in old)]
        if not (mixed or (old and extra)) or _any_alike(new):
            continue
        for pole in mixed:
            log.debug('%.4g Hz: a mixture of modes told apart', pole.frequency_hz)
        # Beside a pole of several modes those of its neighbours are off as well.
        seen = [pole for pole in old if any(_is_view(pole, other) for other in new)]
        stay = [pole for pole in stay if pole not in mixed and pole not in seen]
        instead += new
    return stay, instead


def _is_own(pole: SelectedPole, others: Poles) -> bool:
    """Tell whether the bell of a pole is seen, and no surer one around which it is in doubt."""
    doubtful = pole.from_limit > SELECTION.doubtful
    surer = [other for other in others if other.from_limit < pole.from_limit]
    return not (pole.is_unresolved or (doubtful and any(_is_view(pole, o) for o in surer)))


def _any_alike(poles: Poles) -> bool:
    """Tell whether two poles that touch move alike, as those of one mode that drifts or clips."""
    return any(
        _touch(first, second) and mac(first.shape, second.shape)[0, 0] > SELECTION.same_mac
        for number, first in enumerate(poles)
        for second in poles[:number]
    )


def _is_mixture(pole: SelectedPole, others: Poles) -> bool:
    """Tell whether a pole is none of others, and moves as those do together that it touches."""
    if any(is_same_mode(pole, other) for other in others):
        return False
    near = [other for other in others if _touch(pole, other)]
    near.sort(key=lambda other: abs(other.pole - pole.pole))
    near = near[: len(pole.shape) // 2]
    if not near:
        return False
    basis = np.linalg.qr(np.column_stack([other.shape for other in near]))[0]
    share = np.linalg.norm(basis.conj().T @ pole.shape) ** 2 / np.linalg.norm(pole.shape) ** 2
    return bool(1.0 - share < SELECTION.least_filtered)


def _is_view(first: SelectedPole, second: SelectedPole) -> bool:
    """Tell whether two poles would be in one cluster, were they of one factorisation."""
    width = max(-first.pole.real, -second.pole.real)
    away = abs(first.pole - second.pole) / width
    unlike = 1.0 - float(mac(first.shape, second.shape)[0, 0])
    return is_same_mode(first, second) or away + unlike < SELECTION.cluster_cut


def _touch(first: SelectedPole, second: SelectedPole) -> bool:
    """Tell whether the half-power bandwidths of two poles touch."""
    return bool(_touches((first, second))[0, 1])


def _touching(poles: Poles) -> list[list[SelectedPole]]:
    """Return chains of poles whose half-power bandwidths touch."""
    if not poles:
        return []
    count, label = connected_components(_touches(poles), directed=False)
    return [
        [pole for pole, own in zip(poles, label, strict=True) if own == number]
        for number in range(count)
    ]


def _touches(poles: Poles) -> NDArray[np.bool_]:
    """Tell of each two poles whether their half-power bandwidths touch."""
    return overlaps(
        np.array([pole.frequency_hz for pole in poles]),
        np.array([pole.half_width_hz for pole in poles]),
    )
