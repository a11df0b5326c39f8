"""Measurement files of LabVIEW (.lvm): text with a header that says how it is written.

References
----------
.. [1] National Instruments: Specification for the LabVIEW Measurement File (.lvm),
   https://www.ni.com/en/support/documentation/supplemental/06/specification-for-the-labview-measurement-file---lvm-.html
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import RecordingError
from modal_recordings.disk import check_size
from modal_recordings.formats.named_arrays import NamedArray, NamedArrays
from modal_recordings.text import encoding_of

FIRST_WORDS = 'LabVIEW Measurement'
END = '***End_of_Header***'
LARGEST_BYTES = 1_000_000_000
"""The text is read as a whole; chosen, a quarter of what text that is read by parts may have."""
SEPARATOR, SEPARATORS = 'Separator', {'Tab': '\t', 'Comma': ','}
Header = dict[str, list[str]]


@dataclass(frozen=True, slots=True)
class Segment:
    """Rows behind one header.

    Parameters
    ----------
    header : dict of str to list of str
        Cells behind the first of each line, by that.
    names : list of str
        Cells of the line above the rows.
    rows : list of str
        As written.
    first : int
        Number of the first row's line.
    """

    header: Header
    names: list[str]
    rows: list[str]
    first: int


def is_lvm(path: Path) -> bool:
    """Tell whether a text file is one of these, whatever its name ends in."""
    with path.open(encoding=encoding_of(path)) as file:
        return file.readline(len(FIRST_WORDS)) == FIRST_WORDS


def read(path: Path) -> NamedArrays:
    """Return the channels of a LabVIEW measurement file, and their times where there are any.

    Raises
    ------
    RecordingError
        Truncated, damaged, no record over time, or several segments that are no one record.
    """
    check_size(path, LARGEST_BYTES)
    try:
        text = path.read_text(encoding=encoding_of(path))
    except UnicodeDecodeError as error:
        raise RecordingError('not a text file', where=path, expected='one encoding') from error
    if not text.startswith(FIRST_WORDS):
        raise RecordingError('not a LabVIEW measurement file', where=path, expected=FIRST_WORDS)
    if not text.endswith('\n'):
        raise RecordingError('truncated', where=path, found='a last line without an end')
    lines = text.splitlines()
    said, behind = _file_header(path, lines)
    segments = list(_segments(lines, behind, said[SEPARATOR][0]))
    if not segments:
        raise RecordingError('truncated: no rows', where=path, expected=f'rows behind {END}')
    if len(segments) > 1:
        raise RecordingError(
            'several segments: one recording or several?',
            where=path,
            found=f'{len(segments)} segments',
            expected='one',
            advice='write one segment a file',
        )
    return _arrays(path, segments[0], said)


def _file_header(path: Path, lines: list[str]) -> tuple[Header, int]:
    """Return what the file's own header says, and how many lines it has."""
    number = next((n for n, line in enumerate(lines) if line.startswith(END)), None)
    if number is None:
        raise RecordingError('truncated: its header does not end', where=path, expected=END)
    # The line that tells the separator is written with it.
    told = next((line for line in lines[:number] if line.startswith(SEPARATOR)), 'Tab')
    mark = SEPARATORS.get(told.removeprefix(SEPARATOR).strip(', \t'))
    if mark is None:
        raise RecordingError('unknown separator', where=path, found=told, expected='Tab, Comma')
    said = _cells(lines[:number], mark)
    return {'Decimal_Separator': ['.'], 'X_Columns': ['One'], **said, SEPARATOR: [mark]}, number


def _cells(lines: list[str], mark: str) -> Header:
    """Return the cells behind the first of each line; lines of one cell say nothing."""
    rows = (line.split(mark) for line in lines)
    return {cells[0].strip(): cells[1:] for cells in rows if len(cells) > 1}


def _segments(lines: list[str], behind: int, mark: str) -> Iterator[Segment]:
    """Yield the segments: header, names, rows up to the next header."""
    ends = [n for n, line in enumerate(lines) if n > behind and line.startswith(END)]
    starts = [behind + 1, *(_header_start(lines, end) for end in ends[1:]), len(lines)]
    for number, end in enumerate(ends):
        header = _cells(lines[starts[number] : end], mark)
        names = lines[end + 1].split(mark) if end + 1 < len(lines) else []
        yield Segment(header, names, lines[end + 2 : starts[number + 1]], end + 3)


def _header_start(lines: list[str], end: int) -> int:
    while end > 0 and not lines[end].startswith('Channels'):
        end -= 1
    return end


def _arrays(path: Path, segment: Segment, said: Header) -> NamedArrays:
    n_channels, n_samples = _promised(path, segment)
    dimension = segment.header.get('X_Dimension', ['Time'])[0]
    if dimension.strip() not in ('Time', ''):
        raise RecordingError('no record over time', where=path, found=dimension, expected='Time')
    kind = said['X_Columns'][0].strip()
    # Without times their column is there, and blank; each channel may have times of its own.
    wanted = {
        'One': [0, *range(1, n_channels + 1)],
        'Multi': [0, *range(1, 2 * n_channels, 2)],
        'No': [n + (segment.names[:1] == ['X_Value']) for n in range(n_channels)],
    }.get(kind)
    if wanted is None:
        raise RecordingError('unknown kind', where=f'{path}: X_Columns', found=kind,
                             expected='No, One, Multi')  # fmt: skip
    table = _table(path, segment, said, wanted)
    if len(table) % n_samples:
        # Under one header further packets of as many rows follow without another one.
        raise RecordingError(
            'truncated',
            where=path,
            found=f'{len(table)} rows',
            expected=f'{n_samples}, as its header says, or whole multiples',
        )
    names = [segment.names[column] if column < len(segment.names) else '' for column in wanted]
    units, step_s = segment.header.get('Y_Unit_Label', []), _step_s(path, segment, said)
    times = [] if kind == 'No' else [NamedArray('X_Value', table[:, 0], unit='s')]
    data = table[:, len(times) :]
    return NamedArrays((
        *times,
        *(
            NamedArray(
                name or f'ch{n + 1}',
                data[:, n],
                unit=units[n].strip() if n < len(units) else '',
                headings=(name or f'ch{n + 1}',),
                sample_rate_hz=1.0 / step_s if step_s else None,
            )
            for n, name in enumerate(name.strip() for name in names[len(times) :])
        ),
    ))  # fmt: skip


def _promised(path: Path, segment: Segment) -> tuple[int, int]:
    """Return how many channels there are, and how many samples each has."""
    try:
        n_channels = int(segment.header['Channels'][0])
        counts = {int(cell) for cell in segment.header['Samples'] if cell.strip()}
    except (KeyError, ValueError, IndexError) as error:
        raise RecordingError(
            'damaged header', where=path, expected='Channels and Samples'
        ) from error
    if len(counts) != 1 or n_channels < 1 or min(counts) < 1:
        raise RecordingError(
            'channels of different lengths', where=path, found=', '.join(map(str, sorted(counts)))
        )
    return n_channels, counts.pop()


def _step_s(path: Path, segment: Segment, said: Header) -> float | None:
    cells = [cell for cell in segment.header.get('Delta_X', []) if cell.strip()]
    try:
        steps = {_number(cell, said) for cell in cells}
    except ValueError as error:
        raise RecordingError('not a number', where=f'{path}: Delta_X') from error
    if len(steps) > 1:
        raise RecordingError(
            'channels of different rates',
            where=path,
            found=', '.join(f'{1.0 / step:g} Hz' for step in sorted(steps) if step),
        )
    step_s = steps.pop() if steps else 0.0
    return step_s if step_s > 0.0 else None


def _number(cell: str, said: Header) -> float:
    return float(cell.strip().replace(said['Decimal_Separator'][0].strip() or '.', '.'))


def _table(path: Path, segment: Segment, said: Header, wanted: list[int]) -> NDArray[np.float64]:
    """Return the wanted columns of a segment; remarks behind them are none."""
    mark, decimal = said[SEPARATOR][0], said['Decimal_Separator'][0].strip()
    rows = [row for row in segment.rows if row.strip()]
    if not rows:
        raise RecordingError('truncated: no rows', where=path, expected=f'rows behind {END}')
    found = np.empty((len(rows), len(wanted)))
    for number, row in enumerate(rows):
        cells = row.split(mark)
        try:
            found[number] = [float(cells[n].replace(decimal, '.')) for n in wanted]
        except (ValueError, IndexError) as error:
            raise RecordingError(
                'not a row of numbers',
                where=f'{path}: line {segment.first + number}',
                found=row[:80],
                expected=f'{len(wanted)} numbers',
            ) from error
    return found
