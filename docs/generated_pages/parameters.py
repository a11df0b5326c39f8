"""The reference of the nodes' parameters, out of the tables the nodes declare them from."""

from collections.abc import Iterator, Sequence
import math
from typing import Any, TYPE_CHECKING

from generated_pages.place import cell
from generated_pages.sides import option_of, SIDES

if TYPE_CHECKING:
    from modal_core.settings.node_parameter import NodeParameter


def parameters_page() -> str:
    """Return the page of all nodes, as Markdown without a title."""
    return '\n'.join(_lines())


def node_parameters() -> 'dict[str, tuple[NodeParameter, ...]]':
    """Return the parameters of every node, by its executable."""
    from autonomous_modal_analysis.live.node_tables import parameters_of_node, TABLES

    return {node: parameters_of_node(node) for node in TABLES}


def _lines() -> Iterator[str]:
    for node, rows in node_parameters().items():
        yield f'(parameters-{node})=\n## {node}\n'
        yield f'| parameter | default | range | meaning | `ama {SIDES[node].command}` |'
        yield '|---|---|---|---|---|'
        for row in rows:
            span = '' if row.span is None else f'{row.span[0]:g} to {row.span[1]:g}'
            option = cell(option_of(node, row.name))
            yield (
                f'| `{row.name}` | {_shown(row.default)} | {span} | {cell(row.text)} | {option} |'
            )
        yield ''


def _shown(value: Any) -> str:
    if isinstance(value, str):
        return f'`{value}`' if value else 'empty'
    if isinstance(value, Sequence):
        filled = [item for item in value if item != '' and not _is_nan(item)]
        return f'`{list(filled)}`' if filled else 'empty'
    return f'`{str(value).lower() if isinstance(value, bool) else value}`'


def _is_nan(value: object) -> bool:
    return isinstance(value, float) and math.isnan(value)
