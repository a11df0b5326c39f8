"""What a campaign can tell apart, in words."""

from collections.abc import Iterable, Iterator

from modal_core.words.named import named
from modal_reports import count
from model_gap.decide import NextRecording, Sight, Telling
from model_gap.effects import Effect
from structural_model import FlexibleJointModel
from structural_model.description import value_words

MOST_NAMED = 6
IN_THE_CELL = (
    'these poses lie within the joint limits of the model; whether the cell leaves room for them '
    'is yours to see'
)


def telling_lines(found: Telling, model: FlexibleJointModel) -> list[str]:
    """Return what the command line prints."""
    seen = len(found.sights) - len(found.unseen)
    lines = [f'{seen} of {len(found.sights)} effects of the catalogue would be seen']
    if found.unseen:
        lines.append(f'not seen at a usual size: {_names(found.unseen)}')
    following = [item for item in found.following if max(item.told, item.seen) > 0]
    lines += [f'next: {_words(item, model)}' for item in following]
    if not following:
        lines.append('next: none of the recordings that were considered would tell more')
    if any(item.pose is not None for item in following):
        lines.append(IN_THE_CELL)
    lines += [f'could not be told apart: {names}' for names in _alike(found)]
    if seen and not found.alike:
        lines.append('all that are seen would be told apart')
    return lines


def _alike(found: Telling) -> Iterator[str]:
    """Return which effect could not be told from which, all that concern one sensor together."""
    places: dict[str, tuple[list[Effect], dict[Effect, None]]] = {}
    for effect, others in _pairs(found.alike):
        place = str(effect.location or '')
        key = place if place.startswith('sensor:') else repr(effect)
        own, like = places.setdefault(key, ([], {}))
        own.append(effect)
        like.update(dict.fromkeys(others))
    for key, (own, like) in places.items():
        if key.startswith('sensor:'):
            yield _names(dict.fromkeys((*own, *like)))
        else:
            yield f'{_names(own)} from {_names(like)}'


def _pairs(alike: Iterable[Sight]) -> Iterator[tuple[Effect, list[Effect]]]:
    """Return each effect with those like it that were not told with it before."""
    told: set[frozenset[Effect]] = set()
    for item in alike:
        pairs = {other: frozenset((item.effect, other)) for other in item.like}
        others = [other for other, pair in pairs.items() if pair not in told]
        told.update(pairs.values())
        if others:
            yield item.effect, others


def _names(effects: Iterable[Effect]) -> str:
    """Return effects by type, each with its places, the first few."""
    places: dict[str, list[str]] = {}
    for effect in effects:
        place = f'{effect.location or ""} {effect.variant}'.strip()
        places.setdefault(effect.type.replace('_', ' '), []).append(place)
    parts = []
    for name, own in places.items():
        parts.append(f'{name} ({named(own, MOST_NAMED)})' if any(own) else name)
    return '; '.join(parts)


def _words(item: NextRecording, model: FlexibleJointModel) -> str:
    adds = f'{count(item.seen, "effect")} more seen, {count(item.told, "pair")} more told apart'
    if item.pose is None:
        return f'the same poses, motion {item.factor:g} times as large: {adds}'
    axes = ','.join(map(value_words, model.shown_axes(item.pose), model.sliding))
    return f'--pose-deg={axes}: {adds}'
