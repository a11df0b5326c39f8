"""Arrays of a file by name, and the one table of responses among them."""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
import math
from pathlib import Path
import struct
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import RecordingError
from modal_recordings.disk import spooled
from modal_recordings.tables import (
    array_table,
    ArrayTable,
    Heading,
    heading_of,
    is_of_joints,
    MOST_COLUMNS,
)

RATES = frozenset(
    """fs samplerate samplerateh samplingrate samplefrequency samplingfrequency samplingratehz
    sampleratehz rate ratehz frequency fsample fsampling samplespersecond""".split()
)
STEPS = frozenset(
    """dt ts deltat timestep sampletime samplingtime sampleinterval tsample increment xincrement
    wfincrement""".split()
)
UNIT_WORDS = ('unit', 'units', 'quantity/label', 'einheit')
SAME_RATE = 1e-3
"""Two statements of one rate differ by rounding at most."""
IN_MEMORY_BYTES = 16_000_000
ROWS_AT_ONCE = 1 << 14
DAMAGED = (OSError, RuntimeError, ValueError, TypeError, LookupError, EOFError, struct.error)
"""What libraries raise where values that are read when they are needed cannot be."""
MOST_NAMED = 8
"""Arrays that a message names."""
FEWEST_OF_RECORD = 16
"""Of what can be a record: smaller arrays are lists of places, limits or coefficients."""


class Values(Protocol):
    """Numbers that need not be in memory: an array, or a dataset of a file."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the axes."""

    @property
    def dtype(self) -> np.dtype[np.generic]:
        """Kind of the numbers."""

    def __getitem__(self, key: Any, /) -> Any:
        """Return a part."""


@dataclass(frozen=True, slots=True, eq=False)
class NamedArray:
    """An array of a file.

    Parameters
    ----------
    name : str
        Of the variable, dataset or channel, with those of its groups.
    values : array
        Of one or two axes.
    unit : str
        As written; empty where none is stated.
    headings : tuple of str
        One per column, as written; empty where none is stated.
    sample_rate_hz : float [Hz] or None
        Stated with the array.
    start_s : float [s] or None
        When its first sample was taken, where that is stated.
    units : tuple of str
        One per column, as written; empty: ``unit`` holds for all.
    between_groups : str
        What stands between names of groups; of MATLAB's structures a dot.
    """

    name: str
    values: Values
    unit: str = ''
    headings: tuple[str, ...] = ()
    sample_rate_hz: float | None = None
    start_s: float | None = None
    units: tuple[str, ...] = ()
    between_groups: str = '/'

    @property
    def last_name(self) -> str:
        """Its name without those of its groups."""
        if self.is_row and len(self.headings) == 1:
            return self.headings[0]
        return self.name.rsplit(self.between_groups, 1)[-1]

    @property
    def is_record(self) -> bool:
        """Whether it may hold samples."""
        shape = self.values.shape
        long_enough = len(shape) in (1, 2) and max(shape) >= FEWEST_OF_RECORD
        return long_enough and min(shape) > 0 and self.values.dtype.kind in 'fiu'

    @property
    def is_row(self) -> bool:
        """Whether it has samples of one channel alone."""
        return len(self.values.shape) == 1 or 1 in self.values.shape

    @property
    def n_samples(self) -> int:
        """Length of the longer axis."""
        return max(self.values.shape)


@dataclass(frozen=True, slots=True)
class NamedArrays:
    """All arrays of a file, and the numbers beside them.

    Parameters
    ----------
    arrays : tuple of NamedArray
    numbers : dict of str to float
        By name.
    calibrated : bool
        False: values over full scale.
    texts : dict of str to str
        Words beside them, by name.
    """

    arrays: tuple[NamedArray, ...]
    numbers: dict[str, float] = field(default_factory=dict)
    calibrated: bool = True
    texts: dict[str, str] = field(default_factory=dict)


def table_of(
    path: Path, found: NamedArrays, chosen: Sequence[str] = (), *, with_force: bool = False
) -> ArrayTable:
    """Return the table of responses a file holds.

    Parameters
    ----------
    path : Path
        The file.
    found : NamedArrays
        Its content.
    chosen : sequence of str
        Names of the arrays to use; none: the only one there is, or all that have one length.
    with_force : bool
        Whether one of them is a force, beside responses that may be columns of one array.

    Raises
    ------
    RecordingError
        No array of samples, or several that are no one table.
    """
    records = [each for each in found.arrays if each.is_record]
    arrays = _chosen(path, [_with_unit(path, each, found.texts) for each in records], chosen)
    times = [each for each in arrays if _is_time(each, path)]
    data = [each for each in arrays if each not in times]
    joints = [each for each in data if is_of_joints(each.last_name)]
    # What stands beside joint angles was recorded with them, and what was chosen is wanted.
    if len(data) > 1 and (with_force or chosen or 0 < len(joints) < len(data)):
        data = [column for each in data for column in _columns(each)]
    times = _one_of_alike(times)
    lengths = {each.n_samples for each in arrays}
    if not data:
        raise RecordingError(
            'no array of samples',
            where=path,
            found=_listed(found.arrays) or 'none',
            expected=f'real numbers, {FEWEST_OF_RECORD} samples or more',
        )
    if len(lengths) > 1 and not times:
        _check_lengths(path, arrays)
    if len(lengths) > 1 or (len(data) > 1 and not all(each.is_row for each in data)):
        raise RecordingError(
            'several arrays, which cannot be columns of one table',
            where=path,
            found=_listed(arrays),
            advice='' if with_force else f'say which one: --topic {data[0].name}',
        )
    rate_hz = _rate(path, found.numbers, data)
    _check_together(path, data, rate_hz, chosen)
    table = (
        _matrix(path, data[0], times)
        if len(data) == 1 and not data[0].is_row
        else _side_by_side(path, [*times, *data])
    )
    return replace(table, sample_rate_hz=rate_hz, calibrated=found.calibrated)


def tables_of(path: Path, found: NamedArrays) -> tuple[ArrayTable, ...]:
    """Return the tables a file holds, column by column: one, or one of every length.

    Raises
    ------
    RecordingError
        No array of samples, or several that are no tables: those of two lengths need a time each.
    """
    records = [each for each in found.arrays if each.is_record]
    timed = {each.n_samples for each in records if _is_time(each, path)}
    lengths = {each.n_samples for each in records}
    if len(lengths) > 1 and not lengths <= timed:
        raise RecordingError(
            'arrays of several lengths, and not a time of each',
            where=path,
            found=_listed(records),
            advice='put a vector of times beside each, such as t_joints for joint angles',
        )
    parts: dict[int, list[NamedArray]] = {length: [] for length in sorted(lengths)}
    for each in records:
        parts[each.n_samples] += _columns(each)
    tables = [replace(found, arrays=tuple(part)) for part in parts.values()] or [found]
    return tuple(table_of(path, table) for table in tables)


def _check_lengths(path: Path, arrays: Sequence[NamedArray]) -> None:
    """Name the channels of another length where most have one."""
    usual, n_alike = Counter(each.n_samples for each in arrays).most_common(1)[0]
    if 2 * n_alike <= len(arrays) or not all(each.is_row for each in arrays):
        return
    other = [each for each in arrays if each.n_samples != usual]
    alike = [each.name for each in arrays if each.n_samples == usual]
    raise RecordingError(
        'channels of different lengths',
        where=path,
        found=_listed(other),
        expected=f'{usual} samples, as the {n_alike} others',
        advice='use those of one length alone, as topics: '
        + ', '.join(alike[:MOST_NAMED])
        + ', ...' * (n_alike > MOST_NAMED),
    )


def stated_rates(numbers: dict[str, float]) -> dict[str, float]:
    """Return the rates [Hz] among numbers that have names, a time step as its inverse."""
    stated = {}
    for name, value in numbers.items():
        last = name.replace('.', '/').rsplit('/', 1)[-1].lower()
        word = ''.join(letter for letter in last if letter.isalpha())
        if word in RATES and value > 0.0:
            stated[name] = value
        elif word in STEPS and value > 0.0:
            stated[name] = 1.0 / value
    return stated


def unit_text(value: object) -> str:
    """Return a unit as an attribute holds it; CF conventions: 'seconds since 2024-01-01'."""
    if isinstance(value, np.ndarray) and value.size == 1:
        value = value.ravel()[0]
    text = value.decode('utf-8', 'replace') if isinstance(value, bytes) else str(value)
    return text.split(' since ')[0]


def _with_unit(path: Path, array: NamedArray, texts: dict[str, str]) -> NamedArray:
    """Return an array with the unit that stands beside it, or beside the structure it is in."""
    if array.unit or array.units or not texts or _is_time(array, path):
        return array
    parts = array.name.replace('.', '/').split('/')
    near = {name.replace('.', '/').lower(): text for name, text in texts.items()}
    for n_parts in range(len(parts) - 1, -1, -1):
        for word in UNIT_WORDS:
            text = near.get('/'.join([*parts[:n_parts], word]).lower())
            if text:
                return replace(array, unit=text)
    return array


def _chosen(path: Path, arrays: list[NamedArray], chosen: Sequence[str]) -> list[NamedArray]:
    known = {each.name: each for each in arrays}
    for name in chosen:
        if name not in known:
            raise RecordingError(
                'no such array',
                where=path,
                found=name,
                expected=', '.join(known) or 'none has samples',
            )
    if not chosen:
        return _of_one_length(arrays, path)
    # The only time there is belongs to whatever is chosen.
    times = [each for each in arrays if _is_time(each, path)]
    picked = [known[name] for name in dict.fromkeys(chosen)]
    fits = [each for each in times if each.n_samples == picked[0].n_samples]
    return [*(fits if len(fits) == 1 and fits[0] not in picked else []), *picked]


def _of_one_length(arrays: list[NamedArray], path: Path) -> list[NamedArray]:
    """Leave out what cannot be a response, and times of others, where their length differs."""
    other = [each for each in arrays if _heading(each, path).is_other and each.unit]
    kept = [each for each in arrays if each not in other]
    lengths = {each.n_samples for each in kept if not _is_time(each, path)}
    return [each for each in arrays if each.n_samples in lengths] if len(lengths) == 1 else arrays


def _one_of_alike(times: list[NamedArray]) -> list[NamedArray]:
    """Return the first of times that are all the same: loggers write one with every channel."""
    whole = slice(None)
    if len({each.n_samples for each in times}) == 1:
        first, *others = (_row(each, whole) for each in times)
        if all(np.array_equal(first, other) for other in others):
            return times[:1]
    return times


def _heading(array: NamedArray, path: Path) -> Heading:
    return heading_of(array.last_name, array.unit, f'{path}: {array.name}')


def _is_time(array: NamedArray, path: Path) -> bool:
    heading = _heading(array, path)
    return array.is_row and heading.is_time and not (array.headings or heading.is_counter)


def _rate(path: Path, numbers: dict[str, float], data: Sequence[NamedArray]) -> float | None:
    """Return the rate that is stated anywhere.

    Raises
    ------
    RecordingError
        Two statements contradict one another.
    """
    stated = {each.name: each.sample_rate_hz for each in data if each.sample_rate_hz}
    stated = stated or stated_rates(numbers)
    if not stated:
        return None
    (first, rate_hz), *others = stated.items()
    for name, other_hz in others:
        if not math.isclose(rate_hz, other_hz, rel_tol=SAME_RATE):
            raise RecordingError(
                'rates contradict one another',
                where=path,
                found=f'{first}: {rate_hz:.6g} Hz, {name}: {other_hz:.6g} Hz',
                advice='choose arrays of one rate: --topic NAME for each',
            )
    return rate_hz


def _check_together(
    path: Path, data: Sequence[NamedArray], rate_hz: float | None, chosen: Sequence[str]
) -> None:
    """Refuse to lay arrays side by side, unasked, that may have been measured one by one."""
    if chosen:
        return
    starts = {each.start_s for each in data}
    known = sorted(start for start in starts if start is not None)
    if rate_hz and known and known[-1] - known[0] > 0.5 / rate_hz:
        raise RecordingError(
            'arrays that begin at different times',
            where=path,
            found=f'up to {known[-1] - known[0]:.6g} s apart',
            advice=f'choose those that belong together: --topic {data[0].name}',
        )
    names = [each.last_name for each in data]
    if len(set(names)) < len(names) and None in starts:
        twice = next(each for each in data if names.count(each.last_name) > 1)
        raise RecordingError(
            'one recording or several? names are there more than once, and no start times',
            where=path,
            found=', '.join(each.name for each in data if each.last_name == twice.last_name),
            advice=f'choose those that belong together: --topic {twice.name}',
        )


def _matrix(path: Path, data: NamedArray, times: Sequence[NamedArray]) -> ArrayTable:
    """Return a table of one array with several columns, behind its times."""
    n_rows, n_columns = data.values.shape
    # A time as long as the second axis says that channels come first, whatever their number.
    upright = n_rows >= n_columns or not times
    if upright and n_rows < n_columns:
        array_table(np.broadcast_to(np.float64(0), data.values.shape), path)
    columns = min(n_rows, n_columns)
    headings = data.headings if len(data.headings) == columns else ('',) * columns
    units = data.units if len(data.units) == columns else (data.unit,) * columns
    if columns + len(times) > MOST_COLUMNS:
        raise RecordingError(
            'too many columns', where=path, found=columns, expected=f'<= {MOST_COLUMNS}'
        )

    def rows(part: slice) -> NDArray[np.float64]:
        block = np.asarray(data.values[part] if upright else data.values[:, part].T)
        beside = [_row(each, part)[:, None] for each in times]
        return np.hstack([*beside, block.astype(np.float64)])

    return ArrayTable(
        values=_gathered(path, rows, data.n_samples, columns + len(times)),
        headings=(*(each.last_name for each in times), *headings),
        units=(*(each.unit for each in times), *units),
    )


def _columns(array: NamedArray) -> list[NamedArray]:
    """Return the columns of an array one by one; a row as it is."""
    if array.is_row or min(array.values.shape) > MOST_COLUMNS:
        return [array]
    upright = array.values.shape[0] >= array.values.shape[1]
    columns = range(min(array.values.shape))
    known = len(array.headings) == len(columns)
    return [
        replace(
            array,
            name=array.headings[n] if known else f'{array.name}{n + 1}',
            values=np.asarray(array.values[:, n] if upright else array.values[n]),
            headings=(array.headings[n],) if known else (),
            units=(array.units[n],) if len(array.units) == len(columns) else array.units,
        )
        for n in columns
    ]


def _side_by_side(path: Path, arrays: Sequence[NamedArray]) -> ArrayTable:
    """Return a table of arrays that are one column each."""
    if len(arrays) > MOST_COLUMNS:
        raise RecordingError(
            'too many columns', where=path, found=len(arrays), expected=f'<= {MOST_COLUMNS}'
        )

    def rows(part: slice) -> NDArray[np.float64]:
        return np.column_stack([_row(each, part) for each in arrays])

    names = [each.last_name for each in arrays]
    if len(set(names)) < len(names):
        names = [each.name for each in arrays]
    return ArrayTable(
        values=_gathered(path, rows, arrays[0].n_samples, len(arrays)),
        headings=tuple(names),
        units=tuple(each.unit for each in arrays),
    )


def _row(array: NamedArray, part: slice) -> NDArray[np.float64]:
    shape = array.values.shape
    if len(shape) == 1:
        piece = array.values[part]
    else:
        piece = array.values[0, part] if shape[0] == 1 else array.values[part, 0]
    return np.asarray(piece, dtype=np.float64)


def _gathered(
    path: Path, rows: Callable[[slice], NDArray[np.float64]], n_samples: int, n_columns: int
) -> NDArray[np.float64]:
    """Return the rows, in memory where they are few."""

    def piece(first: int) -> NDArray[np.float64]:
        try:
            return rows(slice(first, min(first + ROWS_AT_ONCE, n_samples)))
        except DAMAGED as error:
            where = f'{path}: rows from {first + 1}'
            raise RecordingError('damaged data', where=where, found=error) from error

    pieces: Iterator[NDArray[np.float64]] = map(piece, range(0, n_samples, ROWS_AT_ONCE))
    if 8 * n_samples * n_columns > IN_MEMORY_BYTES:
        return spooled(path, pieces, n_columns)
    return np.concatenate(list(pieces))


def _listed(arrays: Sequence[NamedArray]) -> str:
    """Name arrays with their shapes."""
    return ', '.join(
        f'{each.name} {" x ".join(map(str, each.values.shape))}' for each in arrays[:MOST_NAMED]
    ) + (f' and {len(arrays) - MOST_NAMED} more' if len(arrays) > MOST_NAMED else '')
