"""The reference of the nodes' parameters, out of the tables the nodes declare them from."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
import math
from typing import Any

from generated_pages.place import cell


@dataclass(frozen=True)
class Row:
    """One parameter as it is shown."""

    name: str
    default: Any
    text: str
    span: tuple[float, float] | None = None


def parameters_page() -> str:
    """Return the page of all nodes, as Markdown without a title."""
    return '\n'.join(_lines())


def node_parameters() -> dict[str, list[Row]]:
    """Return the rows of every node, by its executable."""
    return {
        'oma_identifier': _identifier(),
        'excitation_planner': _planner(),
        'robot_bridge': _bridge(),
        'abb_emulator': _emulator(),
        'replay': _replay(),
    }


def _identifier() -> list[Row]:
    from oma_identifier.node.node_parameters import PARAMETERS

    return [
        Row(p.name, p.default, p.description, None if p.low is None else (p.low, p.high))
        for p in PARAMETERS
    ]


def _bridge() -> list[Row]:
    from robot_bridge.bridge_settings import PARAMETERS

    return [Row(p.name, p.default, p.text, p.span) for p in PARAMETERS]


def _emulator() -> list[Row]:
    from abb_emulator.node.emulator_parameters import PARAMETERS

    return [Row(p.name, p.default, p.text) for p in PARAMETERS]


def _planner() -> list[Row]:
    from excitation_planner.planner_parameters import PARAMETERS

    return [Row(p.name, p.default, p.text, p.span) for p in PARAMETERS]


def _replay() -> list[Row]:
    from robot_bridge.node.replay_parameters import PARAMETERS

    return [Row(name, default, text) for name, default, text in PARAMETERS]


def _lines() -> Iterator[str]:
    for node, rows in node_parameters().items():
        yield f'(parameters-{node})=\n## {node}\n'
        yield '| parameter | default | range | meaning |\n|---|---|---|---|'
        for row in rows:
            span = '' if row.span is None else f'{row.span[0]:g} to {row.span[1]:g}'
            yield f'| `{row.name}` | {_shown(row.default)} | {span} | {cell(row.text)} |'
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
