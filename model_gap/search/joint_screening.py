"""Screen once more: linear effects of the arm and tolerances fitted jointly for a few steps.

One simulation per starting value is not enough for what moves resonances by more than their width:
the tolerances make up for part of it, and what is left looks like nothing.  A few steps of a joint
fit of effect and tolerances find the right one.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
import logging

from modal_core.errors import ModelError
from modal_core.work.side_by_side import side_by_side
from model_gap.campaign import Rows
from model_gap.effects import Effect, same
from model_gap.fit import descend, Numbers, numbers_of, tolerance_columns, with_numbers
from model_gap.hypothesis import Hypothesis
from model_gap.predict import Predictor
from model_gap.search.reach import within_reach
from model_gap.search.screen import Trial

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class JointScreeningLimits:
    """How far effects are followed.

    Parameters
    ----------
    further_steps : int
        Of those that go on, after ``Effect.first_steps`` of every start.
    further, further_starts : int
        So many go on after the first steps, of one effect at most so many.
    """

    further_steps: int = 5
    further: int = 20
    further_starts: int = 2


LIMITS = JointScreeningLimits()
REACH_SHARE = 0.4
"""Of what a free force does at the best place, from where on one is tried at another: the right
place explains all but what tolerances have to do with it."""
Placed = tuple[float, Numbers]


def is_linear(effect: Effect) -> bool:
    """Return whether an effect changes the arm and is linear."""
    return effect.moves_poles and not effect.amplitude_dependent


@dataclass(frozen=True)
class JointScreening:
    """The records effects are screened on, and how tolerances act on them without any new effect.

    Parameters
    ----------
    predictor : Predictor
        Of a few records: one level is enough.
    columns : array
        Tolerance derivatives.
    """

    predictor: Predictor
    columns: Rows

    @classmethod
    def of(cls, base: Hypothesis, predictor: Predictor) -> 'JointScreening':
        """Linearise the tolerances at what the effects are added to."""
        return cls(predictor, tolerance_columns(base, predictor))

    def descend(self, start: Hypothesis, steps: int) -> Placed | None:
        """Return the objective after some steps and where; None from an impossible arm."""
        try:
            found = descend(start, self.predictor, self.columns, steps)
        except ModelError:
            return None
        return found.objective, numbers_of(found.hypothesis)


def screen_jointly(
    screened: Sequence[Trial],
    base: Hypothesis,
    predictor: Predictor,
    reached_from: Hypothesis | None = None,
) -> list[Trial]:
    """Return all trials, linear effects of the arm after a few steps, the most promising first.

    Parameters
    ----------
    screened : sequence of Trial
        Where each begins, beside a few starts of its own; others than linear effects of the arm
        stay as they are.
    base : Hypothesis
        What they are added to.
    predictor : Predictor
        Of a few records.
    reached_from : Hypothesis or None
        Whose residual tells which places are worth it; None: that of the base.
    """
    base = replace(base, held=predictor.hold(base.cell()).held)
    joint = JointScreening.of(base, predictor)
    found_of = dict(enumerate(screened))
    linear = [trial.effect for trial in screened if is_linear(trial.effect)]
    near = within_reach(linear, [reached_from or base], predictor, 0.0, REACH_SHARE)
    running = [n for n, trial in enumerate(screened) if any(trial.effect is it for it in near)]

    def begin(number: int) -> list[Placed]:
        effect = screened[number].effect
        values = (screened[number].values, *map(tuple, effect.few_starts(base.scene)))
        found = [
            joint.descend(base.with_effect(effect, start), effect.first_steps) for start in values
        ]
        return sorted((item for item in found if item), key=lambda item: item[0])[
            : LIMITS.further_starts
        ]

    def go_on(start: Hypothesis) -> Placed | None:
        return joint.descend(start, LIMITS.further_steps)

    begun = zip(running, side_by_side(begin, running), strict=True)
    standing = [(value, number, at) for number, best in begun for value, at in best]
    standing = _going_on(sorted(standing, key=lambda item: item[0]), screened)
    starts = [with_numbers(base, numbers) for _, _, numbers in standing]
    # As often as each effect's own fit: what steps alone gain is no gain of an effect.
    steps = {effect.first_steps for effect in linear}
    bare = {count: joint.descend(base, count + LIMITS.further_steps) for count in steps}
    ends = side_by_side(go_on, starts)
    for (_, number, _), end in zip(standing, ends, strict=True):
        without = bare[screened[number].effect.first_steps]
        if without is None or end is None:
            continue
        gain, at = without[0] - end[0], with_numbers(base, end[1])
        if gain > found_of[number].gain:
            last = len(at.effects) - 1
            before = replace(at.without(last), held=())
            found_of[number] = Trial(at.effects[last], at.values()[last], gain, before)
    log.debug('%d of %d effects screened jointly with the tolerances', len(running), len(screened))
    return sorted(found_of.values(), key=lambda trial: -trial.gain)


def _going_on(
    standing: Sequence[tuple[float, int, Numbers]], screened: Sequence[Trial]
) -> list[tuple[float, int, Numbers]]:
    """Return the closest of all, best first, few of one effect however it was begun."""
    found: list[tuple[float, int, Numbers]] = []
    for item in standing:
        effect = screened[item[1]].effect
        alike = sum(same(effect, screened[other[1]].effect) for other in found)
        if alike < LIMITS.further_starts:
            found.append(item)
    return found[: LIMITS.further]
