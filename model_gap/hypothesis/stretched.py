"""Tolerances stretched far beyond their range stand for something: what it would be by name."""

from collections.abc import Iterable
import dataclasses

import numpy as np

from model_gap.effects import Effect
from model_gap.hypothesis.hypothesis import Hypothesis

# In deviations: ordinary imperfection reaches this once in two thousand tolerances, and where
# recordings that took no part contradict what was fitted, this once in twenty is enough to ask.
STRETCHED = 3.5
DOUBTFUL = 2.0


def stretch(hypothesis: Hypothesis) -> float:
    """Return how far the most stretched tolerance is from nominal, in deviations."""
    return float(np.abs(hypothesis.tolerance_values).max(initial=0.0))


def instead_of_tolerances(
    hypothesis: Hypothesis,
    unstretched: Hypothesis,
    catalogue: Iterable[type[Effect]],
    stretched: float = STRETCHED,
) -> list[Hypothesis]:
    """Return starts with what stretched tolerances may stand for, tolerances as they were before.

    A softer spring or a tool of a few kilograms can be mimicked by tolerances far out of their
    range.  From there an effect gains nothing until all of that is undone: it must start without.
    """
    scene = hypothesis.scene
    values = hypothesis.tolerance_values
    before = dataclasses.replace(hypothesis, tolerance_values=unstretched.tolerance_values)
    far = [
        (item, value)
        for item, value in zip(hypothesis.tolerances, values.tolist(), strict=True)
        if abs(value) > stretched
    ]
    known = [effect.key for effect in hypothesis.effects]
    candidates = [effect for kind in catalogue for effect in kind.instances(scene)]
    return [
        before.with_effect(effect, start)
        for effect in candidates
        if effect.key not in known
        for start in dict.fromkeys(
            tuple(start) for item in far for start in effect.instead_of(*item, scene)
        )
    ]
