"""Names and units of columns from the lines above a table of numbers."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from modal_core.errors import RecordingError
from modal_core.units import known_unit
from modal_recordings.text.text_cells import is_value, not_a_number, NUMBER


@dataclass(frozen=True, slots=True)
class Line:
    """One line above the table, by its number in the file."""

    number: int
    cells: list[str]
    comment: bool


def headings_above(
    path: Path, above: Sequence[Line], n_columns: int, decimal: str
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return names and units of the columns from the lines above the first row.

    Raises
    ------
    RecordingError
        What stands there does not name every column.
    """
    words = [line for line in above if not line.comment]
    # A remark with a name for every column, right above the table, is what numpy.savetxt writes;
    # another one above it may have the names, and the last the units.
    if not words and above and len(above[-1].cells) == n_columns > 1:
        words = [line for line in above[-2:] if len(line.cells) == n_columns]
    if not words:
        return (), ()
    fits = [line for line in words if may_name(line, n_columns, decimal)]
    last = words[-1]
    if not fits or fits[-1] is not last:
        if len(last.cells) == n_columns and last.cells[0] and not is_value(last.cells[0], decimal):
            # Names that are numbers, after a first one that is none: Time, 1, 2, 3.
            return tuple(last.cells), ()
        raise misfit(path, last, n_columns, decimal)
    if len(fits) > 1 and all(_is_unit_cell(cell) for cell in last.cells):
        return _padded(fits[-2].cells, n_columns), _padded(last.cells, n_columns)
    if len(fits) > 1 and _units_behind_time(last.cells):
        return (last.cells[0], *_names_over(fits[:-1])), ('', *last.cells[1:])
    return _padded(last.cells, n_columns), ()


def _units_behind_time(cells: Sequence[str]) -> bool:
    """Tell whether a line names the time and has units for the rest: no name is there twice."""
    rest = cells[1:]
    return all(_is_unit_cell(cell) for cell in rest) and len(set(rest) - {''}) < len(rest)


def _names_over(lines: Sequence[Line]) -> list[str]:
    """Return the last line's names, with those of as many lines above as tell them apart."""
    names = lines[-1].cells[1:]
    for line in reversed(lines[:-1]):
        if len(set(names)) == len(names):
            break
        names = [f'{more} {name}' for more, name in zip(line.cells[1:], names, strict=True)]
    return names


def may_name(line: Line, n_columns: int, decimal: str) -> bool:
    """Tell whether a line may have the names of the columns."""
    named = [cell for cell in line.cells if cell]
    return (
        len(line.cells) == n_columns
        and bool(named)
        and not any(
            NUMBER.fullmatch(cell.replace(decimal, '.')) or cell.lower() == 'nan' for cell in named
        )
    )


def _is_unit_cell(cell: str) -> bool:
    return cell in ('', '-') or known_unit(cell.strip('[]() ')) is not None


def _padded(cells: Sequence[str], n_columns: int) -> tuple[str, ...]:
    return (*cells, *[''] * (n_columns - len(cells)))


def misfit(path: Path, line: Line, n_columns: int, decimal: str) -> RecordingError:
    """Return why a line above the first row is neither names nor numbers."""
    where = f'{path}: line {line.number}'
    if len(line.cells) != n_columns:
        return RecordingError(
            'rows and names above them differ in number',
            where=where,
            found=f'{len(line.cells)} names, {n_columns} columns',
            expected='one name per column',
            advice='decimal commas need another separator than the comma',
        )
    return not_a_number(where, line.cells, decimal)
