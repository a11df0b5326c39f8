"""Tolerances stretched far beyond their range stand for something: what it would be by name."""

import dataclasses

import numpy as np

from model_gap.effects.payload import Payload
from model_gap.effects.places import body_of
from model_gap.hypothesis import Hypothesis

# In deviations: ordinary imperfection reaches this once in two thousand tolerances.
STRETCHED = 3.5


def stretch(hypothesis: Hypothesis) -> float:
    """Return how far the most stretched tolerance is from nominal, in deviations."""
    return float(np.abs(hypothesis.tolerance_values).max(initial=0.0))


def unknown_masses(hypothesis: Hypothesis) -> list[Hypothesis]:
    """Return starts with a mass at every body whose own mass is stretched, tolerances nominal.

    A tool of a few kilograms can be mimicked by masses and centres of mass far out of their
    range.  From there a payload gains nothing until all of that is undone: it must start without.
    """
    scene = hypothesis.scene
    wide = np.abs(hypothesis.tolerance_values) > STRETCHED
    bodies = {
        body_of(scene, item.link)
        for item, far in zip(hypothesis.tolerances, wide, strict=True)
        if far and item.link
    }
    nominal = dataclasses.replace(
        hypothesis, tolerance_values=np.zeros_like(hypothesis.tolerance_values)
    )
    known = [effect.key for effect in hypothesis.effects]
    return [
        nominal.with_effect(effect, tuple(values))
        for effect in Payload.instances(scene)
        if body_of(scene, str(effect.location)) in bodies and effect.key not in known
        for values in effect.few_starts(scene)
    ]
