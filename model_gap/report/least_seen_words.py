"""From which size on effects would have been named, in words."""

from collections.abc import Sequence
import math

from modal_core.words.named import named
from model_gap.decide import LeastSeen
from model_gap.report.telling_words import MOST_NAMED


def least_seen_words(found: Sequence[LeastSeen]) -> list[str]:
    """Return one line per type of effect: where it is seen best and worst, and where not at all.

    Parameters
    ----------
    found : sequence of LeastSeen
        Of every effect and place.
    """
    kinds: dict[str, list[LeastSeen]] = {}
    for item in found:
        kinds.setdefault(item.effect.type, []).append(item)
    return [f'{kind.replace("_", " ")}: {_sizes(own)}' for kind, own in kinds.items()]


def _sizes(own: Sequence[LeastSeen]) -> str:
    seen = sorted((it for it in own if not math.isnan(it.value)), key=lambda it: it.scales)
    unseen = [item.effect.location or 'all' for item in own if math.isnan(item.value)]
    parts = [f'from {_size(seen[0])}'] if seen else []
    if len(seen) > 1:
        parts[0] += f' to {_size(seen[-1])}'
    if unseen:
        at = '' if unseen == ['all'] else f' at {named(unseen, MOST_NAMED)}'
        parts.append(f'at no plausible size{at}')
    return ', '.join(parts)


def _size(item: LeastSeen) -> str:
    name = f'{item.number.name.replace("_", " ")} '
    place = f' ({item.effect.location})' if item.effect.location else ''
    return f'{name}{item.number.said(item.value)}{place}'
