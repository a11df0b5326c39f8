"""A plain array as a recording."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import RecordingError
from modal_core.measurements import (
    Measurement,
    NANOSECONDS_PER_SECOND,
    SampleBlock,
    StampedSamples,
)
from recordings.array_options import ArrayOptions, sidecar_of
from recordings.array_table import ArrayTable
from recordings.info import RecordingInfo
from recordings.read_pages import ReadPages
from recordings.summary import summarise
from recordings.units import to_si

BLOCK_S = 0.25
FEWEST_ROWS = 128
ROWS_AT_ONCE = 1 << 13


class ArrayRecording:
    """Samples from a .npy or .csv file.

    Parameters
    ----------
    path : Path
        The file.
    table : ArrayTable
        Its content.
    options : ArrayOptions
        What the file does not say itself.

    Raises
    ------
    RecordingError
        No rate, wrong number of channel names, unknown unit, a value or time that is not finite.

    Attributes
    ----------
    fraction_read : float
        How much of its rows the last pass has read, 0..1.
    """

    def __init__(self, path: Path, table: ArrayTable, options: ArrayOptions) -> None:
        self.path = path
        self.kind = path.suffix.lstrip('.').lower()
        self.source = path.stem
        self.fraction_read = 0.0
        self._values = table.values
        self.channel_names = _channel_names(path, table, options)
        self.notes: tuple[str, ...] = ()
        unit = options.unit or table.unit
        if not unit:
            unit = 'm/s^2'
            self.notes = (f'no unit stated: taken as {unit}',)
        self.scale = to_si(unit, f'{path}: unit')
        self.stamp_ns = _stamps(path, table, options)
        self.sample_rate_hz = _rate(path, table, options, self.stamp_ns)
        self.start_ns = options.start_ns if self.stamp_ns is None else int(self.stamp_ns[0])
        _check_finite(path, table.values, self.channel_names)

    def info(self) -> RecordingInfo:
        """Return what the file holds."""
        return summarise(
            self, path=str(self.path), kind=self.kind, entries=(), damage=(), notes=self.notes
        )

    def measurements(self) -> Iterator[Measurement]:
        """Yield the samples in stretches of a quarter of a second."""
        step = max(FEWEST_ROWS, round(BLOCK_S * self.sample_rate_hz))
        pages = ReadPages.behind(self._values)
        for first in range(0, len(self._values), step):
            self.fraction_read = min(1.0, (first + step) / len(self._values))
            rows = np.asarray(self._values[first : first + step], dtype=np.float64) * self.scale
            pages.read(rows.nbytes)
            if self.stamp_ns is None:
                offset = round(first * NANOSECONDS_PER_SECOND / self.sample_rate_hz)
                yield SampleBlock(
                    source=self.source,
                    stamp_ns=self.start_ns + offset,
                    first_index=first,
                    sample_rate_hz=self.sample_rate_hz,
                    channel_names=self.channel_names,
                    acceleration=rows,  # type: ignore[arg-type]
                )
            else:
                yield StampedSamples(
                    source=self.source,
                    frame_id='',
                    stamp_ns=self.stamp_ns[first : first + step],
                    acceleration=rows,
                    channel_names=self.channel_names,
                )

    def damage(self) -> tuple[str, ...]:
        """Return nothing: a plain array is read whole or refused."""
        return ()


def _channel_names(path: Path, table: ArrayTable, options: ArrayOptions) -> tuple[str, ...]:
    n_columns = table.values.shape[1]
    names = options.channels or table.names
    if not names:
        names = tuple(f'ch{index + 1}' for index in range(n_columns))
    if len(names) != n_columns:
        raise RecordingError(
            'wrong number of channel names',
            where=f'{path}: channels',
            found=len(names),
            expected=f'{n_columns}, one per column',
        )
    if len(set(names)) != len(names):
        raise RecordingError(
            'channel named twice', where=f'{path}: channels', found=', '.join(names)
        )
    return names


def _stamps(path: Path, table: ArrayTable, options: ArrayOptions) -> NDArray[np.int64] | None:
    """Return the time column in nanoseconds, or None when the rows are a uniform clock."""
    if table.time_s is None or options.sample_rate_hz is not None:
        return None
    if not np.isfinite(table.time_s).all():
        row = int(np.flatnonzero(~np.isfinite(table.time_s))[0])
        raise RecordingError('time is not finite', where=f'{path}: row {row + 1}')
    steps = np.diff(table.time_s)
    if np.median(steps) <= 0.0 or np.abs(table.time_s).max() > 4e9:
        raise RecordingError(
            'time column does not run forward',
            where=path,
            found=f'median step {np.median(steps):g} s',
            expected='> 0 s',
        )
    # Whole seconds apart: a double holds nanoseconds only within a few days.
    whole = np.floor(table.time_s)
    nanoseconds = np.rint((table.time_s - whole) * NANOSECONDS_PER_SECOND)
    stamps = whole.astype(np.int64) * NANOSECONDS_PER_SECOND + nanoseconds.astype(np.int64)
    return np.asarray(stamps - min(0, int(stamps.min())) + options.start_ns)


def _rate(
    path: Path, table: ArrayTable, options: ArrayOptions, stamps: NDArray[np.int64] | None
) -> float:
    if options.sample_rate_hz is not None:
        return options.sample_rate_hz
    if stamps is None:
        raise RecordingError(
            'no sample rate',
            where=f'{path}: sample_rate_hz',
            expected=f'a time column, {sidecar_of(path).name} or the option --sample-rate-hz',
        )
    return NANOSECONDS_PER_SECOND / float(np.median(np.diff(stamps)))


def _check_finite(path: Path, values: NDArray[np.generic], names: tuple[str, ...]) -> None:
    if values.dtype.kind != 'f':
        return
    pages = ReadPages.behind(values)
    for first in range(0, len(values), ROWS_AT_ONCE):
        part = values[first : first + ROWS_AT_ONCE]
        pages.read(part.nbytes)
        if not np.isfinite(part).all():
            row, column = np.argwhere(~np.isfinite(part))[0]
            raise RecordingError(
                'value is not finite',
                where=f'{path}: row {first + row + 1}, channel {names[column]}',
                found=part[row, column],
                expected='finite numbers',
            )
