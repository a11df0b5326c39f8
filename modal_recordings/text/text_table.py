"""Reads tables of numbers from text files of data loggers and spreadsheets."""

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import RecordingError
from modal_recordings.disk import check_size, spooled
from modal_recordings.tables import ArrayTable, is_time_text, MOST_COLUMNS, seconds_of
from modal_recordings.text.text_cells import is_comment, is_no_value, not_a_number, split
from modal_recordings.text.text_layout import LONGEST_LINE, text_layout, TextLayout

LARGEST_BYTES = 4_000_000_000
PIECE_LETTERS = 1 << 20
IN_MEMORY_BYTES = 16_000_000
"""Of text, whose numbers take about as much; those of larger files are mapped."""


def read_text_table(path: Path) -> ArrayTable:
    """Read a text file of numbers, with or without names, units and times.

    Raises
    ------
    RecordingError
        Naming the line and column that is not a number or missing, or what could mean two things.
    """
    check_size(path, LARGEST_BYTES)
    try:
        layout = text_layout(path)
        if layout.n_columns > MOST_COLUMNS:
            raise RecordingError(
                'too many columns',
                where=path,
                found=layout.n_columns,
                expected=f'<= {MOST_COLUMNS}',
            )
        notes = list(layout.notes)
        pieces = _pieces(path, layout, notes)
        values = (
            np.concatenate(list(pieces))
            if path.stat().st_size <= IN_MEMORY_BYTES
            else spooled(path, pieces, layout.n_columns)
        )
    except UnicodeDecodeError as error:
        raise RecordingError(
            'not a text file', where=path, expected='one encoding throughout'
        ) from error
    if len(values) < 2:
        raise RecordingError(
            'not a table', where=path, found=f'shape {values.shape}', expected='at least 2 rows'
        )
    return ArrayTable(
        values=values,
        headings=layout.headings,
        units=layout.units,
        dated=layout.dated,
        sample_rate_hz=layout.sample_rate_hz,
        notes=tuple(notes),
    )


def _is_cut(last: str, before: str, layout: TextLayout) -> bool:
    """Tell whether the last number was cut off: no line end, and fewer digits than above it."""
    cells, above = layout.cells(last), layout.cells(before)
    if last.endswith('\n') or not len(cells) == len(above) == layout.n_columns:
        return False
    there, usual = _digits(cells[-1]), _digits(above[-1])
    return there[0] < usual[0] or there[1] < usual[1]


def _digits(cell: str) -> tuple[int, int]:
    """Return how many digits stand behind the decimal mark, and in the exponent."""
    number, _, exponent = cell.lower().replace(',', '.').partition('e')
    return len(number.partition('.')[2]), len(exponent.lstrip('+-'))


def _pieces(path: Path, layout: TextLayout, notes: list[str]) -> Iterator[NDArray[np.float64]]:
    """Yield the rows, some megabytes of text at a time; one that is cut off is noted, not read."""
    first, lines, n_letters = layout.n_before, [], 0
    with path.open(encoding=layout.encoding, newline=None) as file:
        for number, line in enumerate(iter(lambda: file.readline(LONGEST_LINE), '')):
            if number < layout.n_before:
                continue
            lines.append(line)
            n_letters += len(line)
            if n_letters > PIECE_LETTERS:
                yield _numbers(path, lines, layout, first)
                first, lines, n_letters = number + 1, [], 0
    if len(lines) > 1 and _is_cut(lines[-1], lines[-2], layout):
        notes.append('last row left out: it ends in the middle of a number')
        lines.pop()
    if lines:
        yield _numbers(path, lines, layout, first)


def _numbers(path: Path, lines: list[str], layout: TextLayout, first: int) -> NDArray[np.float64]:
    """Return the numbers of some lines, the first of them after ``first`` others."""
    rows = [_row(line, layout) for line in lines if not is_comment(line)]
    rows = [row for row in rows if row]
    if not rows:
        return np.empty((0, layout.n_columns))
    if layout.decimal == ',' and layout.separator != ',':
        rows = [row.replace(',', '.') for row in rows]
    values = _loaded(rows, layout)
    if values is None:
        # Seldom: cells without a number are looked for where there are some.
        values = _loaded([_without_words(row, layout) for row in rows], layout)
    if values is None:
        raise _complaint(path, lines, layout, first)
    return values


def _loaded(rows: list[str], layout: TextLayout) -> NDArray[np.float64] | None:
    """Return the numbers of rows; None where one of them is none."""
    try:
        values: NDArray[np.float64] = np.loadtxt(
            rows,
            delimiter=layout.separator,
            ndmin=2,
            comments='#',
            quotechar='"',
            dtype=np.float64,
            converters=_converters(layout),
            encoding=None,
        )
    except (ValueError, IndexError):
        return None
    return values if values.shape[1] == layout.n_columns else None


def _without_words(row: str, layout: TextLayout) -> str:
    """Return a row with NaN for cells that say that there is no number."""
    mark = layout.separator
    cells = row.split(mark)
    cells = ['nan' if is_no_value(cell.strip(' \t"')) else cell for cell in cells]
    return (mark or ' ').join(cells)


def _row(line: str, layout: TextLayout) -> str:
    """Return a line without separators at its end, but those before cells that may be blank."""
    mark = layout.separator or ''
    row = line.rstrip(f'{mark} \t\r\n')
    if not row or not mark:
        return row
    there = min(line.count(mark), layout.n_columns - 1)
    return row + mark * (there - row.count(mark))


def _converters(layout: TextLayout) -> dict[int | str, Callable[[str], float]] | None:
    made: dict[int | str, Callable[[str], float]] = {}
    if layout.decimal == ',' and layout.separator == ',':
        made = dict.fromkeys(range(layout.n_columns), lambda cell: float(cell.replace(',', '.')))
    for column, order in zip(layout.dated, layout.orders, strict=True):
        made[column] = partial(seconds_of, order=order)
    return made or None


def _complaint(path: Path, lines: list[str], layout: TextLayout, first: int) -> RecordingError:
    """Find the first row that is wrong."""
    for number, line in enumerate(lines, start=first + 1):
        if not line.strip() or is_comment(line):
            continue
        # A blank last cell is a cell without a value here, not one too few.
        cells = split(line.split(' #')[0], layout.separator, layout.n_columns)
        error = _fault(f'{path}: line {number}', cells, layout)
        if error is not None:
            return error
    return RecordingError('not a table of numbers', where=path)


def _fault(where: str, cells: list[str], layout: TextLayout) -> RecordingError | None:
    if len(cells) != layout.n_columns:
        return RecordingError(
            'row too short' if len(cells) < layout.n_columns else 'row too long',
            where=where,
            found=f'{len(cells)} columns',
            expected=layout.n_columns,
        )
    for column, cell in enumerate(cells):
        if column in layout.dated:
            if not is_time_text(cell):
                return not_a_time(f'{where}, column {column + 1}')
            try:
                seconds_of(cell, layout.orders[layout.dated.index(column)])
            except ValueError as error:
                return not_a_time(f'{where}, column {column + 1}', str(error))
        elif not layout.is_number(cell):
            return not_a_number(where, cells, layout.decimal)
    return None


def not_a_time(where: str, reason: str = 'not a date or time') -> RecordingError:
    """Return the error for a cell that should be a time."""
    return RecordingError(reason, where=where, expected='ISO 8601, such as 2024-05-31T12:00:00.5')
