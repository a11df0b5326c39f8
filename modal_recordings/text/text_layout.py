"""How a text file writes its table: encoding, separator, decimal mark, headings, first row."""

from collections import Counter, deque
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
import re

from modal_core.errors import RecordingError
from modal_core.words.printable import printable
from modal_recordings.tables import date_order, DateOrder, has_date, is_time_text
from modal_recordings.text.stated_rate import stated_rate_hz
from modal_recordings.text.text_cells import is_comment, is_no_value, is_value, split
from modal_recordings.text.text_encoding import encoding_of
from modal_recordings.text.text_headings import headings_above, Line, may_name, misfit

HEAD_LINES = 500
LONGEST_LINE = 1_000_000
FEW_LINES = 20
NO_DATE = 'date not used, only the time of day: which number is the day and which the month?'


@dataclass(frozen=True, slots=True)
class TextLayout:
    """How a text file writes its table.

    Parameters
    ----------
    encoding : str
        Of the text.
    separator : str or None
        Between cells; None: blanks.
    decimal : str
        Decimal mark.
    n_before : int
        Lines before the first row of numbers.
    n_columns : int
        Cells of a row.
    headings, units : tuple of str
        Of the columns as written; empty when there are none.
    dated : tuple of int
        Columns of dates or times of day.
    sample_rate_hz : float [Hz] or None
        Stated above the table.
    orders : tuple of (3,) tuple of int or None
        Of year, month and day in those columns; None where the dates do not tell.
    notes : tuple of str
        What of it is not used.
    """

    encoding: str
    separator: str | None
    decimal: str
    n_before: int
    n_columns: int
    headings: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    dated: tuple[int, ...] = ()
    sample_rate_hz: float | None = None
    orders: tuple[DateOrder | None, ...] = ()
    notes: tuple[str, ...] = ()

    def cells(self, line: str) -> list[str]:
        """Return the cells of a line; a separator at its end begins no cell but a blank one."""
        return split(line, self.separator, self.n_columns)

    def is_number(self, cell: str) -> bool:
        """Tell whether a cell is a number or says that there is none."""
        return is_value(cell, self.decimal)


def text_layout(path: Path) -> TextLayout:
    """Find out how a text file writes its table, from its beginning.

    Raises
    ------
    RecordingError
        There is no table, or what is above it does not fit it.
    """
    encoding = encoding_of(path)
    lines = _head(path, encoding)
    stated = re.match(r'\s*"?sep=(.)"?\s*$', lines[0]) if lines else None
    rows = [(n, line) for n, line in enumerate(lines) if line.strip() and not (stated and n == 0)]
    plain = [line for _, line in rows if not is_comment(line)]
    if not plain:
        raise RecordingError('empty file', where=path, found='no row', expected='a table')
    body = plain if len(plain) <= FEW_LINES else plain[len(plain) // 2 :]
    separator = stated.group(1) if stated else _separator(body)
    counts = Counter(len(split(line, separator)) for line in body)
    n_columns = max(counts, key=lambda count: (counts[count], count))
    decimal = _decimal(path, [split(line, separator) for line in body], separator)
    n_columns = _n_named(plain, separator, decimal) or n_columns
    sparse = _sparse([split(line, separator, n_columns) for line in body], n_columns)
    above = []
    for number, line in rows:
        comment = is_comment(line)
        cells = split(line.lstrip('#%/ \t') if comment else line, separator)
        filled = split(line, separator, n_columns)
        n_blank = sum(column not in sparse for column in range(len(cells), n_columns))
        if not comment and len(filled) == n_columns and 2 * n_blank < n_columns:
            if _is_row(filled, decimal):
                break
        above.append(Line(number + 1, cells, comment))
    else:
        raise _no_row(path, above, n_columns, decimal)
    dated = tuple(index for index, cell in enumerate(filled) if is_time_text(cell))
    headings, units = headings_above(path, above, n_columns, decimal)
    rate_hz = stated_rate_hz(path, [line for n, line in rows if n < number])
    orders = _orders(path, encoding, separator, filled, dated)
    unclear = (filled[n] for n, order in zip(dated, orders, strict=True) if order is None)
    notes = tuple(f'{NO_DATE} ({cell})' for cell in unclear if has_date(cell))
    layout = (encoding, separator, decimal, number, n_columns)
    return TextLayout(*layout, headings, units, dated, rate_hz, orders, notes)


def _orders(
    path: Path, encoding: str, separator: str | None, first: Sequence[str], dated: Sequence[int]
) -> tuple[DateOrder | None, ...]:
    """Return the order of year, month and day in columns of dates, from both ends of the file."""
    orders = tuple(date_order([first[column]]) for column in dated)
    if all(order or not has_date(first[n]) for order, n in zip(orders, dated, strict=True)):
        return orders
    with path.open(encoding=encoding, newline=None) as file:
        last = deque(iter(lambda: file.readline(LONGEST_LINE), ''), FEW_LINES)
    rows = [first, *(split(line, separator, len(first)) for line in last)]
    rows = [cells for cells in rows if len(cells) == len(first)]
    return tuple(date_order([cells[n] for cells in rows if is_time_text(cells[n])]) for n in dated)


def _n_named(plain: Sequence[str], separator: str | None, decimal: str) -> int:
    """Return how many columns there are where some rows have all that is named; else 0.

    The others lack what is blank at their end.
    """
    if separator is None:
        return 0
    lines = [Line(0, split(line, separator), comment=False) for line in plain]
    widest = max((len(line.cells) for line in lines if _is_row(line.cells, decimal)), default=0)
    named = (all(line.cells) and may_name(line, widest, decimal) for line in lines)
    return widest if any(named) else 0


def _sparse(rows: Sequence[Sequence[str]], n_columns: int) -> tuple[int, ...]:
    """Return the columns that are blank in most rows."""
    whole = [cells for cells in rows if len(cells) == n_columns]
    blank = [sum(is_no_value(cells[column]) for cells in whole) for column in range(n_columns)]
    return tuple(column for column, n in enumerate(blank) if n > len(whole) / 2)


def _head(path: Path, encoding: str) -> list[str]:
    lines = []
    with path.open(encoding=encoding, newline=None) as file:
        for line in iter(lambda: file.readline(LONGEST_LINE), ''):
            if len(line) >= LONGEST_LINE:
                raise RecordingError(
                    'line too long', where=path, expected=f'< {LONGEST_LINE} letters'
                )
            lines.append(line)
            if len(lines) >= HEAD_LINES:
                break
    return lines


def _separator(body: Sequence[str]) -> str | None:
    def used(mark: str) -> bool:
        return 2 * sum(mark in line for line in body) >= len(body)

    for mark in '\t;|':
        if used(mark):
            return mark
    if not used(','):
        return None
    # Blanks inside the cells that commas would make: 1,5 2,5 are two numbers with decimal commas.
    apart = sum(any(_is_pair(cell) for cell in split(line, ',')) for line in body)
    return None if 2 * apart > len(body) else ','


def _is_pair(cell: str) -> bool:
    return bool(re.search(r'\d\s+[-+.\d]', cell)) and not is_time_text(cell)


def _decimal(path: Path, rows: Sequence[Sequence[str]], separator: str | None) -> str:
    """Return the decimal mark; refuse marks that could mean two things."""
    cells = [cell for row in rows for cell in row if cell and not is_time_text(cell)]
    commas = [
        cell for cell in cells if re.fullmatch(r'[-+]?[\d.,]*,[\d.,]+(?:[eE][-+]?\d+)?', cell)
    ]
    points = [cell for cell in cells if '.' in cell and is_value(cell, '.')]
    if not commas:
        # 0,05 between commas leaves 05, -0,5 leaves -0: no program prints such whole numbers.
        if (
            separator == ','
            and not points
            and any(re.fullmatch(r'-0|[-+]?0\d+', c) for c in cells)
        ):
            raise _unclear(
                path, 'decimal comma beside commas between columns', 'columns apart by ;'
            )
        return '.'
    both = next((cell for cell in commas if '.' in cell or cell.count(',') > 1), None)
    if both is not None:
        raise _unclear(path, 'thousands separators', 'numbers without', both)
    if points:
        raise _unclear(path, 'decimal points and decimal commas', 'one of them', commas[0])
    groups = [re.fullmatch(r'[-+]?[1-9]\d{0,2},\d{3}', cell) is not None for cell in commas]
    if all(groups) and len(commas) < len(cells):
        raise _unclear(path, 'a comma before three digits may stand for thousands',
                       'decimal points', commas[0])  # fmt: skip
    return ','


def _unclear(path: Path, what: str, expected: str, found: str | None = None) -> RecordingError:
    shown = None if found is None else printable(found, 40)
    return RecordingError(what, where=path, found=shown, expected=expected)


def _is_row(cells: Sequence[str], decimal: str) -> bool:
    numbers = [is_value(cell, decimal) for cell in cells]
    return all(
        number or is_time_text(cell) for number, cell in zip(numbers, cells, strict=True)
    ) and not all(is_no_value(cell) for cell in cells)


def _no_row(path: Path, above: Sequence[Line], n_columns: int, decimal: str) -> RecordingError:
    last = next(line for line in reversed(above) if not line.comment)
    if len(above) > 1 and any(is_value(cell, decimal) for cell in last.cells):
        return misfit(path, last, n_columns, decimal)
    return RecordingError('no row of numbers', where=path, expected='a table')
