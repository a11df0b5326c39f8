"""Plain arrays from .npy and .csv files, with what the file itself says about them."""

from collections.abc import Sequence
import csv
from dataclasses import dataclass
import io
import itertools
from pathlib import Path
import re

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import RecordingError
from recordings.unreadable import unreadable_npy

MOST_COLUMNS = 1024
LARGEST_CSV_BYTES = 4_000_000_000
TIME_NAME = re.compile(r'^\s*(time|timestamp|stamp|t)\b', re.IGNORECASE)
UNIT_IN_NAME = re.compile(r'[\[(]\s*([^\])]+?)\s*[\])]\s*$')
TIME_UNITS = {'s': 1.0, 'sec': 1.0, 'seconds': 1.0, 'ms': 1e-3, 'us': 1e-6, 'µs': 1e-6, 'ns': 1e-9}


@dataclass(frozen=True, slots=True)
class ArrayTable:
    """A table of samples as the file states it.

    Parameters
    ----------
    values : (n_samples, n_channels) array
        In the file's own unit; may be a memory map.
    names : tuple of str
        One per column; empty when the file does not say.
    unit : str
        Unit named in the header; empty when it does not say.
    time_s : (n_samples,) array [s] or None
        Time column.
    """

    values: NDArray[np.generic]
    names: tuple[str, ...] = ()
    unit: str = ''
    time_s: NDArray[np.float64] | None = None


def read_npy(path: Path) -> ArrayTable:
    """Map a .npy file into memory.

    Raises
    ------
    RecordingError
        Truncated, pickled, not numbers, or not a table of samples by channels.
    """
    try:
        values = np.load(path, mmap_mode='r', allow_pickle=False)
    except (ValueError, OSError, EOFError, SyntaxError, OverflowError, MemoryError) as error:
        raise unreadable_npy(path) from error
    if not isinstance(values, np.ndarray) or values.dtype.kind not in 'fiu':
        raise RecordingError(
            'not real numbers',
            where=path,
            found=getattr(values, 'dtype', type(values).__name__),
            expected='floats or integers',
        )
    if values.ndim == 1:
        values = values[:, np.newaxis]
    if values.ndim != 2 or not 0 < values.shape[1] <= MOST_COLUMNS or len(values) < 2:
        raise RecordingError(
            'not a table',
            where=path,
            found=f'shape {values.shape}',
            expected=f'(samples, channels), at least 2 samples, at most {MOST_COLUMNS} channels',
        )
    if values.shape[1] > values.shape[0]:
        raise RecordingError(
            'more channels than samples',
            where=path,
            found=f'shape {values.shape}',
            expected='samples along the first axis',
        )
    return ArrayTable(values=values)


def read_csv(path: Path) -> ArrayTable:
    """Read a .csv file with or without header and time column.

    Raises
    ------
    RecordingError
        Naming the line and column that is not a number or missing.
    """
    size = path.stat().st_size
    if size > LARGEST_CSV_BYTES:
        raise RecordingError(
            'file too large', where=path, found=size, expected=f'at most {LARGEST_CSV_BYTES} bytes'
        )
    try:
        text = path.read_text(encoding='utf-8-sig')
    except OSError as error:
        raise RecordingError(f'cannot be read: {error.strerror}', where=path) from error
    except UnicodeDecodeError as error:
        raise RecordingError(
            'not a text file',
            where=path,
            found=f'byte {error.object[error.start]:#04x} at byte {error.start}',
            expected='UTF-8',
        ) from error
    first = next((line for line in io.StringIO(text) if line.strip()), '')
    if not first:
        raise RecordingError('empty file', where=path, found='no line', expected='a table')
    separator = next((mark for mark in (',', ';', '\t') if mark in first), None)
    cells = _cells(first, separator)
    names = tuple(cells) if not all(_is_number(cell) for cell in cells) else ()
    values = _numbers(path, text, separator, bool(names), len(cells))
    if len(values) < 2 or not 0 < values.shape[1] <= MOST_COLUMNS:
        raise RecordingError(
            'not a table', where=path, found=f'shape {values.shape}', expected='at least 2 rows'
        )
    return _with_names(values, names)


def _with_names(values: NDArray[np.float64], names: tuple[str, ...]) -> ArrayTable:
    time_s = None
    if names and TIME_NAME.match(names[0]) and values.shape[1] > 1:
        unit = UNIT_IN_NAME.search(names[0])
        time_s = values[:, 0] * TIME_UNITS.get(unit.group(1).lower() if unit else 's', 1.0)
        values, names = values[:, 1:], names[1:]
    found = [match.group(1) for name in names if (match := UNIT_IN_NAME.search(name))]
    unit_name = found[0] if len(found) == len(names) and len(set(found)) == 1 else ''
    plain = tuple(
        re.sub(r'\s*-\s*', '-', UNIT_IN_NAME.sub('', name).strip()) or f'ch{index + 1}'
        for index, name in enumerate(names)
    )
    return ArrayTable(values=values, names=plain, unit=unit_name, time_s=time_s)


def _numbers(
    path: Path, text: str, separator: str | None, header: bool, n_columns: int
) -> NDArray[np.float64]:
    try:
        return np.loadtxt(
            io.StringIO(text),
            delimiter=separator,
            skiprows=_header_lines(text) if header else 0,
            usecols=range(n_columns),
            ndmin=2,
            comments='#',
            dtype=np.float64,
        )
    except (ValueError, IndexError) as error:
        raise _complain(path, text, separator, header, n_columns) from error


def _header_lines(text: str) -> int:
    """Return the lines up to and including the first that is not blank."""
    blank = itertools.takewhile(lambda line: not line.strip(), io.StringIO(text))
    return len(list(blank)) + 1


def _complain(
    path: Path, text: str, separator: str | None, header: bool, n_columns: int
) -> RecordingError:
    """Find the first cell that is wrong."""
    skip = _header_lines(text) if header else 0
    for number, line in enumerate(io.StringIO(text), start=1):
        if number <= skip or not line.strip() or line.startswith('#'):
            continue
        cells = _cells(line, separator)
        if len(cells) < n_columns:
            return RecordingError(
                'row too short',
                where=f'{path}: line {number}',
                found=f'{len(cells)} columns',
                expected=n_columns,
            )
        for column, cell in enumerate(cells[:n_columns], start=1):
            if not _is_number(cell):
                return RecordingError(
                    'not a number',
                    where=f'{path}: line {number}, column {column}',
                    found=repr(cell[:40]),
                )
    return RecordingError('not a table of numbers', where=path)


def _cells(line: str, separator: str | None) -> Sequence[str]:
    if separator is None:
        return line.split()
    cells = [cell.strip() for cell in next(csv.reader([line], delimiter=separator))]
    # A separator at the end of the line begins no column.
    while len(cells) > 1 and cells[-1] == '':
        cells.pop()
    return cells


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
