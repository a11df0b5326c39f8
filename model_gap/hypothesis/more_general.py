"""Laws of which a hypothesis has the special case."""

from collections.abc import Iterable

from model_gap.effects import Effect
from model_gap.hypothesis.hypothesis import Hypothesis


def more_general(hypothesis: Hypothesis, catalogue: Iterable[type[Effect]]) -> list[Hypothesis]:
    """Return starts of the laws whose special case the last effect is, in its place."""
    special, number = hypothesis.effects[-1], len(hypothesis.effects) - 1
    values = hypothesis.values()[number]
    fewer = hypothesis.without(number)
    found = []
    for kind in catalogue:
        if kind.special_case == special.type:
            effect = kind(special.location, special.variant)
            if special.detailed() is None:  # what it has free, the general law has free as well
                effect = effect.detailed() or effect
            found += [fewer.with_effect(effect, start) for start in effect.generalise(values)]
    return found


def is_special_case(one: Effect, other: Effect) -> bool:
    """Return whether an effect is the special case of another one at the same place."""
    here = (one.location, one.variant) == (other.location, other.variant)
    return here and one.type == other.special_case
