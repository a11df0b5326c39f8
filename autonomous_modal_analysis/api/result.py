"""What all results can do: show themselves, and become plain values, JSON and tables."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from autonomous_modal_analysis.api.optional import optional
from autonomous_modal_analysis.identified.results import json_text

MOST_ROWS = 30
"""Rows of a result that are shown; all are in its table."""
Columns = Mapping[str, Sequence[Any]]


class Result(ABC):
    """A result: one line that says what it is, and a table."""

    @abstractmethod
    def headline(self) -> str:
        """Say in one line what this is."""

    @abstractmethod
    def columns(self) -> Columns:
        """Return the table by column, all of one length; names carry units."""

    @abstractmethod
    def shown(self) -> Columns:
        """Return the table as people read it, texts by column."""

    @abstractmethod
    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain values, as the command line's ``--json`` prints them."""

    def to_json(self) -> str:
        """Return everything as strict JSON (RFC 8259); a number that is not known is null."""
        return json_text(self.to_dict())

    def to_dataframe(self) -> Any:
        """Return the table as a :class:`pandas.DataFrame`, one row per entry.

        Raises
        ------
        ModalAnalysisError
            pandas is not installed.
        """
        return optional('pandas').DataFrame(dict(self.columns()))

    def __repr__(self) -> str:
        """Return the headline and the first rows."""
        shown = self.shown()
        rows = list(zip(*shown.values(), strict=True))
        head = [list(shown), *map(list, rows[:MOST_ROWS])] if rows else []
        widths = [max(map(len, column)) for column in zip(*head, strict=True)]
        lines = [
            '  ' + '  '.join(cell.rjust(width) for cell, width in zip(row, widths, strict=True))
            for row in head
        ]
        if len(rows) > MOST_ROWS:
            lines.append(f'  ... {len(rows) - MOST_ROWS} more')
        return '\n'.join((self.headline(), *lines))

    def _repr_html_(self) -> str:
        """Return the headline and the table for a notebook."""
        shown = self.shown()
        head = ''.join(f'<th>{escape(name)}</th>' for name in shown)
        rows = [
            ''.join(f'<td>{escape(cell)}</td>' for cell in row)
            for row in zip(*shown.values(), strict=True)
        ]
        body = ''.join(f'<tr>{row}</tr>' for row in rows[:MOST_ROWS])
        more = f'<p>... {len(rows) - MOST_ROWS} more</p>' if len(rows) > MOST_ROWS else ''
        table = f'<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>{more}'
        return f'<p>{escape(self.headline())}</p>{table if rows else ""}'
