"""Cells of a line of text, and which of them are numbers."""

from collections.abc import Sequence
import csv
import re

from modal_core.errors import RecordingError
from modal_core.words.printable import printable

NUMBER = re.compile(r'[-+]?(?:\d+[.]?\d*|[.]\d+)(?:[eE][-+]?\d+)?', re.ASCII)
NO_VALUE = re.compile(
    r'|n/?a|<na>|null|none|[-+*]+|[-+]?(?:nan(?:\((?:snan|ind)\))?|inf(?:inity)?)'
    r'|[-+]?1[.]#(?:ind|inf|qnan|snan)0*|#(?:n/?a(?: n/a)?|value!|div/0!|num!|ref!|name[?]|null!)'
    r'|[-+]?(?:ol|ovld|ovrng|over(?:load|range|flow)?)',
    re.IGNORECASE,
)
"""What stands where there is no number: blanks and dashes, what pandas reads as such (na_values),
what C libraries print (1.#IND, -nan(ind)), errors of spreadsheets, overloads of instruments."""
COMMENT = re.compile(r'\s*(?:#(?!(?:n/?a|value!|div/0!|num!|ref!|name[?]|null!)\W)|%|//)', re.I)


def split(line: str, separator: str | None, n_least: int = 1) -> list[str]:
    """Return the cells of a line; separators at its end begin none beyond so many."""
    if separator is None:
        return line.split()
    cells = [cell.strip() for cell in next(csv.reader([line], delimiter=separator), [])]
    while len(cells) > n_least and cells[-1] == '':
        cells.pop()
    return cells


def is_comment(line: str) -> bool:
    """Tell whether a line is a remark."""
    return COMMENT.match(line) is not None


def is_no_value(cell: str) -> bool:
    """Tell whether a cell says that there is no number."""
    return NO_VALUE.fullmatch(cell) is not None


def is_value(cell: str, decimal: str) -> bool:
    """Tell whether a cell is a number, or says that there is none."""
    if is_no_value(cell):
        return True
    return NUMBER.fullmatch(cell.replace(decimal, '.')) is not None and (
        decimal == '.' or '.' not in cell
    )


def not_a_number(where: str, cells: Sequence[str], decimal: str) -> RecordingError:
    """Return the error that names the first cell that is no number."""
    column = next((n for n, cell in enumerate(cells, 1) if not is_value(cell, decimal)), 1)
    return RecordingError(
        'not a number',
        where=f'{where}, column {column}',
        found=repr(printable(cells[column - 1], 40)),
    )
