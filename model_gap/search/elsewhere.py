"""The best effect at every other place, fitted: a place is sure only where no other does as well.

Another axis of the same link is another place: details turn an axis only so far.
What a screening promises decides what is fitted; where tolerances or free details hide an effect,
or a joint between two places hardly twists, a place that explains as well may not be among that.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
import logging

import numpy as np
from numpy.typing import NDArray

from modal_core.work.side_by_side import side_by_side
from model_gap.effects import Effect, on_link, same, Scene, turned, turns
from model_gap.fit import with_numbers
from model_gap.hypothesis import Hypothesis
from model_gap.predict import Predictor
from model_gap.search.joint_screening import is_linear, JointScreening, Placed, REACH_SHARE
from model_gap.search.reach import within_reach

Array = NDArray[np.float64]
log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class ElsewhereLimits:
    """Which places are fitted.

    Parameters
    ----------
    start_steps, place_steps : int
        Of descent from every start, and from the best of each place.
    starts : int
        So many of each place go on after the first steps.
    far_behind : float
        Log probability that a place may then be behind the best one. Chosen, not measured.
    """

    start_steps: int = 3
    place_steps: int = 10
    starts: int = 2
    far_behind: float = 50.0


LIMITS = ElsewhereLimits()
Start = tuple[Effect, tuple[float, ...]]


def _ends(
    joint: JointScreening, base: Hypothesis, starts: Sequence[Start]
) -> list[tuple[float, Hypothesis]]:
    """Return the objective at every place, from the starts that are best after a few steps."""

    def begin(start: Hypothesis) -> Placed | None:
        return joint.descend(start, LIMITS.start_steps)

    def go_on(start: Hypothesis) -> Placed | None:
        return joint.descend(start, LIMITS.place_steps)

    first: dict[str | None, list[Placed]] = {}
    begun = side_by_side(begin, [base.with_effect(*start) for start in starts])
    for (effect, _), found in zip(starts, begun, strict=True):
        first.setdefault(effect.location, []).extend([found] if found else [])
    best = [sorted(some, key=lambda end: end[0])[: LIMITS.starts] for some in first.values()]
    better = [with_numbers(base, numbers) for some in best for _, numbers in some]
    ends = [end for end in side_by_side(go_on, better) if end]
    return [(value, with_numbers(base, numbers)) for value, numbers in ends]


def elsewhere(best: Hypothesis, without: Hypothesis, predictor: Predictor) -> list[Hypothesis]:
    """Return the last effect at every place that explains nearly as much, roughly fitted there.

    Two ways lead there: with its own numbers from where the best one is, for what explains as
    well predicts alike; and with usual ones, no details free, from where there is none, for wide
    tolerances make up for one place otherwise than for another.

    Parameters
    ----------
    best : Hypothesis
        With what is to be placed last.
    without : Hypothesis
        Fitted without it.
    predictor : Predictor
        Of the records the rough fits are made on.

    Returns
    -------
    list of Hypothesis
        One per place, of several axes and ways the best.
    """
    last = len(best.effects) - 1
    effect, base, scene = best.effects[last], best.without(last), best.scene
    places = [
        place
        for place in type(effect).instances(scene)
        if not any(same(place, it) for it in base.effects)
    ]
    if all(same(place, effect) for place in places):
        return []
    near = within_reach(places, [base], predictor, 0.0, REACH_SHARE)
    near = [place for place in near if not same(place, effect)]
    if not near:
        return []
    held = predictor.hold(base.cell()).held
    best, base, without = (replace(item, held=held) for item in (best, base, without))
    here = JointScreening.of(best, predictor)
    own = here.descend(best, LIMITS.place_steps)
    if own is None:
        return []
    values, pose = best.values()[last], predictor.poses[0]
    free = [_as_free(place, effect) for place in near]
    ends = _ends(here, base, [(it, _carried(it, effect, values, scene, pose)) for it in free])
    if is_linear(effect):
        usual = [(place, tuple(start)) for place in near for start in place.few_starts(scene)]
        ends += _ends(JointScreening.of(without, predictor), without, usual)
    found: dict[str | None, Hypothesis] = {}
    for value, placed in sorted(ends, key=lambda end: end[0]):
        other = placed.effects[last]
        if other.location in found:
            continue
        log.debug('%r: %.3g behind %r', other, value - own[0], effect)
        if value - own[0] < LIMITS.far_behind:
            found[other.location] = replace(placed, held=())
    return list(found.values())


def _as_free(other: Effect, effect: Effect) -> Effect:
    """Return an effect with its details free where those of another are."""
    return (other.detailed() or other) if effect.detailed() is None else other


def _carried(
    place: Effect, effect: Effect, values: Sequence[float], scene: Scene, pose: Array
) -> tuple[float, ...]:
    """Return the numbers of an effect for another place of it: where it is in space, and along."""
    numbers = {
        item.name: value for item, value in zip(effect.parameters(scene), values, strict=True)
    }
    point = tuple(numbers[name] for name in effect.point if name in numbers)
    if point:
        moved = on_link(scene, point, str(effect.location), str(place.location), pose)
        numbers |= zip(place.point, moved, strict=True)
    turned_by = tuple(numbers[name] for name in effect.turns if name in numbers)
    if turned_by:
        along = turned(effect.variant, turned_by)
        origin, end = (
            on_link(scene, it, str(effect.location), str(place.location), pose)
            for it in ((0.0, 0.0, 0.0), along)
        )
        there = [two - one for one, two in zip(origin, end, strict=True)]
        numbers |= zip(place.turns, turns(place.variant, there), strict=True)
    items = place.parameters(scene)
    wanted = (numbers.get(item.name, item.neutral) for item in items)
    return tuple(item.value(item.inner(x)) for item, x in zip(items, wanted, strict=True))
