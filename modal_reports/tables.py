"""Tables of a report: headings, cells and what aligns them."""

from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup

from modal_reports.numbers import Number, UNKNOWN
from modal_reports.quantities import Quantity


@dataclass(frozen=True, slots=True)
class Cell:
    """One cell.

    Parameters
    ----------
    content : str
        Text, or ``Markup`` of a chart.
    kind : str
        ``number``: right-aligned; ``sigma``: the deviation behind a number; ``chart``;
        ``free``: long text that may wrap; ``bad``: a fault; empty for text.
    span : int
        Columns it takes.
    """

    content: str
    kind: str = ''
    span: int = 1


@dataclass(frozen=True, slots=True)
class Row:
    """One row.

    Parameters
    ----------
    cells : sequence of Cell
        As many columns as the table has.
    kind : str
        ``best``: stands out; ``aside``: stands back; ``bad``: a fault; empty for most.
    """

    cells: Sequence[Cell]
    kind: str = ''


@dataclass(frozen=True, slots=True)
class Table:
    """One table.

    Parameters
    ----------
    label : str
        What it shows, for readers who hear it.
    headings : sequence of Cell
        Of the columns.
    rows : sequence of Row
        From top to bottom.
    caption : str
        Above the table.
    empty : str
        Said where there are no rows.
    """

    label: str
    headings: Sequence[Cell]
    rows: Sequence[Row]
    caption: str = ''
    empty: str = 'none'

    @property
    def n_columns(self) -> int:
        """How many columns it has."""
        return sum(heading.span for heading in self.headings)


def text(content: str) -> Cell:
    """Return a cell of text."""
    return Cell(content)


def number(content: str) -> Cell:
    """Return a cell of a number, or the heading of such."""
    return Cell(content, 'number')


def measured(quantity: Quantity, value: Number, std: Number) -> tuple[Cell, Cell]:
    """Return two cells of a value and its standard deviation, aligned at the ±."""
    return value_and_sigma(*quantity.pair(value, std))


def value_and_sigma(value: str, std: str) -> tuple[Cell, Cell]:
    """Return the two cells of a value and its standard deviation that are words already."""
    return Cell(value, 'number'), Cell(std if std == UNKNOWN else f'± {std}', 'sigma')


def heading(quantity: Quantity) -> Cell:
    """Return the heading over the two cells of a measured quantity."""
    return Cell(quantity.heading, 'number', 2)


def tags(*words: tuple[str, str]) -> Cell:
    """Return a cell of short remarks, each (words, kind): ``bad``, ``doubt`` or empty."""
    made = (
        Markup('<span class="tag {}">{}</span>').format(kind, said) for said, kind in words if said
    )
    return Cell(Markup(' ').join(made), 'tags')
