"""The best effect at every other place, fitted: a place is sure only where no other does as well.

What a screening promises decides what is fitted; where tolerances or free details hide an effect,
or a joint between two places hardly twists, a place that explains as well may not be among that.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
import logging

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import ModelError
from modal_core.work.side_by_side import side_by_side
from model_gap.effects import Effect, on_link, same, Scene
from model_gap.fit import descend, Numbers, numbers_of, tolerance_columns, with_numbers
from model_gap.hypothesis import Hypothesis
from model_gap.predict import Predictor
from model_gap.search.reach import within_reach

Array = NDArray[np.float64]
log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class ElsewhereLimits:
    """Which places are fitted.

    Parameters
    ----------
    least_reach_share : float
        Only where a free force would explain this share of what one does at the best place: a
        right place explains all but what tolerances have to do with it.
    start_steps, place_steps : int
        Of descent from every start, and from the best of each place.
    far_behind : float
        Log probability that a place may then be behind the best one. Chosen, not measured.
    """

    least_reach_share: float = 0.4
    start_steps: int = 3
    place_steps: int = 10
    far_behind: float = 50.0


LIMITS = ElsewhereLimits()
Placed = tuple[float, Numbers]


def elsewhere(best: Hypothesis, predictor: Predictor) -> list[Hypothesis]:
    """Return the last effect at every place that explains nearly as much, roughly fitted there.

    A place that was tried before is tried again: from numbers that fit elsewhere the way is short.

    Parameters
    ----------
    best : Hypothesis
        With what is to be placed last.
    predictor : Predictor
        Of the records the rough fits are made on.

    Returns
    -------
    list of Hypothesis
        One per place, of several axes the best.
    """
    last = len(best.effects) - 1
    effect, base, values = best.effects[last], best.without(last), best.values()[last]
    places = [
        place
        for place in type(effect).instances(best.scene)
        if not any(same(place, it) for it in base.effects)
    ]
    if all(place.location == effect.location for place in places):
        return []
    near = within_reach(places, [base], predictor, 0.0, LIMITS.least_reach_share)
    near = [place for place in near if place.location != effect.location]
    if not near:
        return []
    base = replace(base, held=predictor.hold(base.cell()).held)
    # Where the best one is: what explains as well predicts alike.
    best = replace(best, held=base.held)
    columns = tolerance_columns(best, predictor)

    def down(start: Hypothesis, steps: int) -> Placed | None:
        try:
            found = descend(start, predictor, columns, steps)
        except ModelError:
            return None  # not a possible arm
        return found.objective, numbers_of(found.hypothesis)

    def begin(start: Hypothesis) -> Placed | None:
        return down(start, LIMITS.start_steps)

    def go_on(start: Hypothesis) -> Placed | None:
        return down(start, LIMITS.place_steps)

    starts = [
        base.with_effect(place, _carried(place, effect, values, best.scene, predictor.poses[0]))
        for other in near
        for place in [_as_free(other, effect)]
    ]
    first: dict[str | None, Placed] = {}
    for start, found in zip(starts, side_by_side(begin, starts), strict=True):
        location = start.effects[-1].location
        if found and (location not in first or found[0] < first[location][0]):
            first[location] = found
    begun = [with_numbers(base, numbers) for _, numbers in first.values()]
    ends = side_by_side(go_on, [best, *begun])
    own = ends[0]
    placed = []
    for item in ends[1:]:
        if item is None or own is None:
            continue
        there = with_numbers(base, item[1])
        log.debug('%r: %.3g behind %r', there.effects[-1], item[0] - own[0], effect)
        if item[0] - own[0] < LIMITS.far_behind:
            placed.append(replace(there, held=()))
    return placed


def _as_free(other: Effect, effect: Effect) -> Effect:
    """Return an effect with its details free where those of another are."""
    return (other.detailed() or other) if effect.detailed() is None else other


def _carried(
    place: Effect, effect: Effect, values: Sequence[float], scene: Scene, pose: Array
) -> tuple[float, ...]:
    """Return the numbers of an effect for another place of it, a point where it is in space."""
    numbers = {
        item.name: value for item, value in zip(effect.parameters(scene), values, strict=True)
    }
    point = tuple(numbers[name] for name in effect.point if name in numbers)
    if point:
        moved = on_link(scene, point, str(effect.location), str(place.location), pose)
        numbers |= zip(place.point, moved, strict=True)
    items = place.parameters(scene)
    wanted = (numbers.get(item.name, item.neutral) for item in items)
    return tuple(item.value(item.inner(x)) for item, x in zip(items, wanted, strict=True))
