"""Maps of numbers by rows and columns, coloured by size: gaps by sensor and band, MAC."""

from collections.abc import Callable, Sequence

from markupsafe import Markup
import numpy as np
from numpy.typing import NDArray

from modal_reports.charts import svg
from modal_reports.palette import HeatScale

Array = NDArray[np.float64]
CELL, HEIGHT, GAP = 40, 24, 60
TOP = 44
LETTER = 6.4
LEAST_MARGIN, MOST_LETTERS = 40, 24


def heat_map(
    label: str,
    rows: Sequence[str],
    columns: Sequence[str],
    panels: Sequence[tuple[str, Array]],
    scale: HeatScale,
    words: Callable[[float], str],
) -> Markup:
    """Draw one map or several beside each other.

    Parameters
    ----------
    label : str
        What the picture shows.
    rows, columns : sequence of str
        Names.
    panels : sequence of (title, (n_rows, n_columns) array)
        What is not finite stays empty.
    scale : HeatScale
        Colour of a number.
    words : callable
        Text of a number.
    """
    margin = _margin(rows)
    wide = len(columns) * CELL
    parts = [
        svg.text(margin - 8, TOP + 15 + HEIGHT * row, _short(name), anchor='end')
        for row, name in enumerate(rows)
    ]
    for number, (title, values) in enumerate(panels):
        left = margin + number * (wide + GAP)
        parts.append(svg.text(left, 16, title, 'title'))
        parts += [
            svg.text(left + (column + 0.5) * CELL, 36, name, anchor='middle')
            for column, name in enumerate(columns)
        ]
        for (row, column), value in np.ndenumerate(values):
            if np.isfinite(value):
                parts += _cell(left + column * CELL, row, scale.step(value), words(float(value)))
    width = margin + len(panels) * wide + (len(panels) - 1) * GAP
    return svg.svg((width + 4, TOP + HEIGHT * len(rows) + 4), label, parts, 'heat')


def _cell(x: float, row: int, step: int, words: str) -> tuple[str, str]:
    y = TOP + HEIGHT * row
    return (
        svg.rectangle(f'heat-{step}', x, y, CELL - 2, HEIGHT - 2),
        svg.text(x + CELL / 2 - 1, y + 15, words, f'cell on-heat-{step}', 'middle'),
    )


def _margin(names: Sequence[str]) -> int:
    return max(LEAST_MARGIN, round(LETTER * max((len(_short(n)) for n in names), default=0)) + 12)


def _short(name: str) -> str:
    return name if len(name) <= MOST_LETTERS else f'{name[: MOST_LETTERS - 1]}…'
