"""What a campaign can tell apart, in words."""

from collections.abc import Iterable, Iterator

import numpy as np

from modal_reports import count
from model_gap.decide import NextRecording, Sight, Telling
from model_gap.effects import Effect
from structural_model import FlexibleJointModel

MOST_NAMED = 6


def telling_lines(found: Telling, model: FlexibleJointModel) -> list[str]:
    """Return what the command line prints."""
    seen = len(found.sights) - len(found.unseen)
    lines = [f'{seen} of {len(found.sights)} effects of the catalogue would be seen']
    if found.unseen:
        lines.append(f'not seen at a usual size: {_names(found.unseen)}')
    lines += [
        f'could not be told apart: {_names([effect])} from {_names(others)}'
        for effect, others in _pairs(found.alike)
    ]
    if seen and not found.alike:
        lines.append('all that are seen would be told apart')
    lines += [
        f'next: {_words(item, model)}' for item in found.following if max(item.told, item.seen) > 0
    ]
    if not any(max(item.told, item.seen) > 0 for item in found.following):
        lines.append('next: none of the recordings that were considered would tell more')
    return lines


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
        more = f' and {len(own) - MOST_NAMED} more' if len(own) > MOST_NAMED else ''
        parts.append(f'{name} ({", ".join(own[:MOST_NAMED])}{more})' if any(own) else name)
    return '; '.join(parts)


def _words(item: NextRecording, model: FlexibleJointModel) -> str:
    adds = f'{count(item.seen, "effect")} more seen, {count(item.told, "pair")} more told apart'
    if item.pose is None:
        return f'the same poses, motion {item.factor:g} times as large: {adds}'
    angles = ','.join(f'{angle:.1f}' for angle in np.degrees(model.to_controller(item.pose)))
    return f'--pose-deg={angles}: {adds}'
