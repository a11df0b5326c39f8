"""Weighs the parts of a robot as causes of a change, one at a time."""

from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from modal_history.alarm.evidence import Evidence
from modal_history.alarm.part import Part, SURE, Suspect

Array = NDArray[np.float64]
ROUGH, ROUGH_SHARE = 0.2, 0.02
"""Deviation of a sensitivity of the model: a share of it, and so much of any (chosen: strain
energies of a model whose stiffnesses are each known to 20 % move by about that)."""
LEAST_CHANGE, LARGEST_CHANGE, N_CHANGES = 1e-3, 0.7, 600
"""Changes of the logarithm of a stiffness that are weighed; a load by as many times 100 kg."""
LOAD_KG = 100.0
UNLIKELY = 0.01
"""Chance below which no single part is taken to explain what is seen."""


@dataclass(frozen=True, slots=True)
class Kind:
    """A part that may change.

    Parameters
    ----------
    kind, place : str
        As for :class:`~modal_history.alarm.part.Suspect`.
    """

    kind: str
    place: str = ''


def weigh(parts: Sequence[Kind], modes: Sequence[Evidence]) -> Part:
    """Return which part it is, as far as the modes tell.

    Each part alone is a hypothesis, all alike before; its change is integrated over sizes that
    are alike on a logarithmic scale.

    Parameters
    ----------
    parts : sequence of Kind
        Columns of the sensitivities.
    modes : sequence of Evidence
        One per mode that was found before and after.
    """
    if not modes or not parts:
        return Part(why='no mode with a baseline is near one of the model')
    found = [_Weighed.of(number, modes) for number in range(len(parts))]
    logs = np.array([each.log for each in found])
    chances = np.exp(logs - logs.max())
    chances /= chances.sum()
    order = np.argsort(chances)[::-1]
    listed = order[: int(np.searchsorted(np.cumsum(chances[order]), SURE)) + 1]
    suspects = tuple(_suspect(parts[i], found[i], float(chances[i])) for i in listed)
    if found[order[0]].chance < UNLIKELY:
        return Part((), 'no single part of the model explains how the modes moved')
    if len(suspects) > 1 and len({each.place or each.kind for each in suspects}) == 1:
        both = suspects[0]
        total = sum(each.chance for each in suspects)
        return Part((Suspect('joint', both.place, both.change, both.change_std, total),))
    return Part(suspects, '' if len(suspects) == 1 else 'the data do not tell them apart')


@dataclass(frozen=True, slots=True)
class _Weighed:
    """One part as the cause: log of the evidence, its change ± its deviation.

    ``chance`` is how likely modes that follow it leave as much as is left.
    """

    log: float
    change: float
    std: float
    chance: float

    @classmethod
    def of(cls, part: int, modes: Sequence[Evidence]) -> '_Weighed':
        sizes = np.geomspace(LEAST_CHANGE, LARGEST_CHANGE, N_CHANGES)
        change = np.concatenate([-sizes[::-1], sizes])
        left, both = np.zeros(len(change)), np.zeros(len(change))
        for mode in modes:
            one, two = mode.misfit(part, change, ROUGH, ROUGH_SHARE)
            left, both = left + one, both + two
        weight = np.exp(-0.5 * (both - both.min()))
        mean = float(weight @ change / weight.sum())
        variance = float(weight @ (change - mean) ** 2 / weight.sum())
        log = float(np.log(weight.mean()) - 0.5 * both.min())
        more = float(left[np.argmin(both)]) - sum(mode.least(part) for mode in modes)
        # Each mode's own factor and constant, of which one is the change.
        return cls(log, mean, math.sqrt(variance), float(chi2.sf(more, 2 * len(modes) - 1)))


def _suspect(part: Kind, found: _Weighed, chance: float) -> Suspect:
    if part.kind == 'load':
        return Suspect(part.kind, '', LOAD_KG * found.change, LOAD_KG * found.std, chance)
    factor = math.exp(found.change)
    return Suspect(part.kind, part.place, factor - 1.0, factor * found.std, chance)
