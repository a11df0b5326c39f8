"""Tables on the terminal and in docs/explanation/results, pictures in docs/images."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from benchmarks.results import write_rows
from modal_reports import palette

IMAGES = Path(__file__).resolve().parents[2] / 'docs' / 'images'
COLOURS, GREY, PALE = palette.SERIES, palette.SERIES_GREY, palette.SERIES_PALE
WIDTH = 112


def show_table(
    title: str, columns: Sequence[str], rows: Sequence[Sequence[object]], keep: str = ''
) -> None:
    """Print a table, first column left, the others right; ``keep`` names it in the documents."""
    table = Table(title=title, title_justify='left', title_style='bold')
    for number, column in enumerate(columns):
        table.add_column(column, justify='right' if number else 'left')
    for row in rows:
        table.add_row(*(str(cell) for cell in row))
    Console(width=WIDTH).print(table)
    if keep:
        write_rows(
            f'paper_{keep}', columns, [[str(cell) for cell in row] for row in rows], [title]
        )


def say(text: str) -> None:
    """Print a line of explanation."""
    Console(width=WIDTH, highlight=False).print(text)


def panels(n_rows: int, n_columns: int, size: tuple[float, float]) -> tuple[Any, Any]:
    """Return a figure and its axes, in the style all pictures share."""
    import matplotlib

    matplotlib.use('agg')
    from matplotlib import pyplot

    matplotlib.rcParams.update(
        {
            'font.size': 9,
            'axes.spines.top': False,
            'axes.spines.right': False,
            'axes.grid': True,
            'grid.color': palette.SERIES_GRID,
            'axes.axisbelow': True,
            'axes.titlesize': 9,
            'axes.titlelocation': 'left',
            'legend.frameon': False,
        }
    )
    return pyplot.subplots(n_rows, n_columns, figsize=size, layout='constrained', squeeze=False)


def save(figure: Any, name: str) -> None:
    """Write a picture; the same figures give the same bytes."""
    IMAGES.mkdir(parents=True, exist_ok=True)
    figure.savefig(IMAGES / name, metadata={'Software': None}, dpi=130)
    say(f'drawn: docs/images/{name}\n')
