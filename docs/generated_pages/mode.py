"""The table of a mode's fields, out of the dataclass itself."""

from collections.abc import Iterator
import math
from typing import Any

from generated_pages.place import cell

KINDS = {float: 'number', int: 'whole number', bool: 'true or false', complex: 'complex array'}


def mode_page() -> str:
    """Return the table of the fields of a mode, as Markdown without a title."""
    return '\n'.join(_lines())


def _lines() -> Iterator[str]:
    from modal_core.mode import MODE_FIELDS

    yield '| field | kind | unit | range | meaning |\n|---|---|---|---|---|'
    for item in MODE_FIELDS:
        names = ', '.join(f'`{key}`' for key in item.keys)
        about = f'{names} | {KINDS[item.kind]} | {item.unit} | {_span(item)} | {cell(item.text)}'
        yield f'| {about} |'


def _span(item: Any) -> str:
    if math.isinf(item.low):
        return ''
    return f'{item.low:g} on' if math.isinf(item.high) else f'{item.low:g} to {item.high:g}'
