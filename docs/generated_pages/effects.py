"""The catalogue of effects, out of the classes."""

from collections.abc import Iterator
from typing import Any

from generated_pages.place import cell


def effects_page() -> str:
    """Return the catalogue, as Markdown without a title."""
    from model_gap.effects import CATALOGUE

    return '\n'.join(line for effect in CATALOGUE for line in _section(effect))


def _section(effect: Any) -> Iterator[str]:
    place = f'{effect.__module__}.{effect.__qualname__}'
    yield f'(effect-{effect.type})=\n## {effect.type}\n'
    yield f'```text\n{effect.equation}\n```\n'
    yield f'| | |\n|---|---|\n| class | {{py:obj}}`~{place}` |'
    yield f'| signature | {cell(effect.signature)} |\n| source | {cell(effect.source)} |'
    for other, way in effect.confused_with.items():
        yield f'| told from `{other}` by | {cell(way)} |'
    yield ''
