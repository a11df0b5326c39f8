"""Fit every linear effect of the arm for a few steps, tolerances following, and see who is ahead.

One simulation per starting value is not enough for what moves resonances by more than their width:
the tolerances make up for part of it, and what is left looks like nothing.  A few steps of a joint
fit of effect and tolerances find the right one.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from modal_core.errors import ModelError
from model_gap.effects.effect import Effect
from model_gap.fit import descend, objective
from model_gap.hypothesis import Hypothesis
from model_gap.linearise import misfit, Rows, tolerance_columns, Weighting
from model_gap.predict import Predictor
from model_gap.reach import within_reach
from model_gap.screen import Trial

FIRST_STEPS = 2
FURTHER_STEPS = 5
# Only where a free force would explain this share of what one does at the best place: the right
# place explains all but what tolerances have to do with it.
REACH_SHARE = 0.4
# So many go on after the first steps, of one effect at most so many.
FURTHER = 20
FURTHER_STARTS = 2
# Of every type so many more, this far from neutral in prior deviations.
OF_TYPE = 3
FAR = 0.1


def runs(effect: Effect) -> bool:
    """Return whether an effect changes the arm and is linear."""
    return effect.moves_poles and not effect.amplitude_dependent


@dataclass(frozen=True)
class Track:
    """The records a race is run on, and how tolerances act on them without any new effect.

    Parameters
    ----------
    predictor, weighting
        Of a few records: one level is enough.
    columns : array
        Tolerance derivatives.
    """

    predictor: Predictor
    weighting: Weighting
    columns: Rows

    @classmethod
    def of(cls, base: Hypothesis, predictor: Predictor, weighting: Weighting) -> 'Track':
        """Linearise the tolerances at what the effects are added to."""
        return cls(predictor, weighting, tolerance_columns(base, predictor, weighting))

    def run(self, start: Hypothesis, steps: int) -> tuple[float, Hypothesis] | None:
        """Return the objective and where it is after some steps; None from an impossible arm."""
        try:
            found = descend(start, self.predictor, self.weighting, self.columns, steps)
        except ModelError:
            return None
        rows = self.weighting.rows(self.predictor.predict(found.setup()))
        return objective(misfit(self.weighting, rows), found), found


Entry = tuple[float, int, Hypothesis]


def ahead(standing: Sequence[Entry]) -> list[Entry]:
    """Return who goes on: the best, few of one effect, and of every type some that moved far.

    Where tolerances have made up for most of a gap, the right effect must first undo that, and is
    behind for some steps, also behind smaller ones of its own kind.
    """
    ordered = sorted(standing, key=lambda item: item[0])
    leaders: list[Entry] = []
    for item in ordered:
        if sum(other[1] == item[1] for other in leaders) < FURTHER_STARTS:
            leaders.append(item)
    leaders = leaders[:FURTHER]
    of_type: dict[str, list[Entry]] = {}
    for item in ordered:
        if gone_far(item[2]) and not any(item is other for other in leaders):
            of_type.setdefault(item[2].effects[-1].type, []).append(item)
    return [*leaders, *(item for group in of_type.values() for item in group[:OF_TYPE])]


def gone_far(hypothesis: Hypothesis) -> bool:
    """Return whether the first number of the last effect is far from nothing."""
    count = len(hypothesis.effects[-1].parameters(hypothesis.scene))
    return bool(abs(hypothesis.inner[-count]) > FAR * hypothesis.prior_scale[-count])


def race(
    screened: Sequence[Trial], base: Hypothesis, predictor: Predictor, weighting: Weighting
) -> list[Trial]:
    """Return all trials, linear effects of the arm after a few steps, the most promising first.

    Parameters
    ----------
    screened : sequence of Trial
        Where each begins, beside a few starts of its own; others than linear effects of the arm
        stay as they are.
    base : Hypothesis
        What they are added to.
    predictor, weighting
        Of a few records.
    """
    base = replace(base, held=predictor.hold(base.setup()).held)
    track = Track.of(base, predictor, weighting)
    standing: list[Entry] = []
    found_of = dict(enumerate(screened))
    linear = [trial.effect for trial in screened if runs(trial.effect)]
    near = within_reach(linear, [base], predictor, 0.0, REACH_SHARE)
    for number, trial in enumerate(screened):
        effect = trial.effect
        if not any(effect is item for item in near):
            continue
        values = [trial.values, *map(tuple, effect.few_starts(base.scene))]
        found = [track.run(base.with_effect(effect, start), FIRST_STEPS) for start in values]
        standing += [(run[0], number, run[1]) for run in found if run]
    without = track.run(base, FIRST_STEPS + FURTHER_STEPS)
    for _, number, hypothesis in ahead(standing):
        further = track.run(hypothesis, FURTHER_STEPS)
        if without is None or further is None:
            continue
        gain, at = without[0] - further[0], further[1]
        if gain > found_of[number].gain:
            last = len(at.effects) - 1
            before = replace(at.without(last), held=())
            found_of[number] = Trial(at.effects[last], at.values()[last], gain, before)
    return sorted(found_of.values(), key=lambda trial: -trial.gain)
