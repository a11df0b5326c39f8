"""Places of one effect that a campaign does not tell apart."""

from collections.abc import Sequence

from model_gap.effects import Effect
from model_gap.search import Candidate, RivalPair


def is_place(pair: RivalPair) -> bool:
    """Return whether two explanations are one effect at two places."""
    return pair.accepted.effect.type == pair.rival.effect.type


def open_places(pairs: Sequence[RivalPair], effect: Effect) -> tuple[Candidate, ...]:
    """Return an accepted effect at the other places where it explains as well.

    Parameters
    ----------
    pairs : sequence of RivalPair
        Of a search.
    effect : Effect
        An accepted one.
    """
    key = effect.key
    return tuple(it.rival for it in pairs if it.accepted.effect.key == key and is_place(it))


def place_reasons(pairs: Sequence[RivalPair]) -> tuple[str, ...]:
    """Return of which effects it is the place that is not told."""
    effects = {it.accepted.effect.key: it.accepted.effect for it in pairs if is_place(it)}
    found = []
    for effect in effects.values():
        others = (str(item.effect.location) for item in open_places(pairs, effect))
        places = ' or '.join(dict.fromkeys((str(effect.location), *others)))
        name = effect.type.replace('_', ' ')
        found.append(f'{name} at {places}: it explains the recordings as well at each of them')
    return tuple(found)
