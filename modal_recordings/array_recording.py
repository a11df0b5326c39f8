"""A plain array as a recording."""

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modal_core.measurements import (
    Measurement,
    NANOSECONDS_PER_SECOND,
    SampleBlock,
    StampedSamples,
)
from modal_core.spindle_speed import SpindleSpeed
from modal_recordings.contents import RecordingInfo, summarise
from modal_recordings.disk import ReadPages
from modal_recordings.messages import Attachment
from modal_recordings.tables import (
    array_clock,
    array_columns,
    ArrayColumns,
    ArrayOptions,
    ArrayTable,
    JointRows,
)

BLOCK_S = 0.25
FEWEST_ROWS = 128
ROWS_AT_ONCE = 1 << 13
MOST_NAMED = 4


@dataclass(frozen=True, slots=True, eq=False)
class ReadFrom:
    """What a recording of columns was made from.

    Parameters
    ----------
    table : ArrayTable
        Its content.
    options : ArrayOptions
        What the file does not say itself.
    notes : tuple of str
        What was done before.
    speed_hz : (n_rows,) array or None [Hz]
        Speed of the spindle.
    joints : JointRows or None
        Joint states of the same rows, from columns that are not in the table.
    names : tuple of str
        Of the channels; empty: as in the file.
    """

    table: ArrayTable
    options: ArrayOptions
    notes: tuple[str, ...] = ()
    speed_hz: NDArray[np.float64] | None = None
    joints: JointRows | None = None
    names: tuple[str, ...] = ()


class ArrayRecording:
    """Samples from a .npy or .csv file, or from an array in memory.

    Parameters
    ----------
    path : Path
        The file, or the name of what is in memory.
    table, options, notes, speed_hz, joints, names
        See :class:`ReadFrom`.

    Raises
    ------
    RecordingError
        No rate, wrong number of channel names, unknown unit, a value or time that is not finite.

    Attributes
    ----------
    fraction_read : float
        How much of its rows the last pass has read, 0..1.
    left_out : tuple of str
        What of the file takes no part, and how its times were read.
    notes : tuple of str
        The same, behind what was assumed of units.
    units_told : bool
        Whether somebody stated the units.
    """

    def __init__(
        self,
        path: Path,
        table: ArrayTable,
        options: ArrayOptions,
        notes: tuple[str, ...] = (),
        speed_hz: NDArray[np.float64] | None = None,
        joints: JointRows | None = None,
        names: tuple[str, ...] = (),
    ) -> None:
        self.path = path
        self.kind = path.suffix.lstrip('.').lower() or 'array'
        self.source = path.stem
        self.fraction_read = 0.0
        self.read_from = ReadFrom(table, options, notes, speed_hz, joints, names)
        columns = array_columns(path, table, options)
        clock = array_clock(path, table, columns, options)
        self._values, self._columns, self._scale = table.values, columns.channels, columns.scale
        self.units, self.units_told = columns.units, columns.units_told
        self.channel_names = names or columns.names
        left_out = (*notes, *table.notes, *columns.notes, *clock.notes)
        n_lost = _n_lost(table.values, columns)
        self._is_empty = bool((n_lost == len(table.values)).all())
        self.left_out = (*left_out, *_told(n_lost, columns))
        self.notes = (*columns.assumed, *self.left_out)
        self.stamp_ns, self.sample_rate_hz = clock.stamp_ns, clock.sample_rate_hz
        self.start_ns = clock.start_ns
        self._speed_hz, self._joints = speed_hz, joints
        self._clock, self._has_gyroscopes = clock, bool(columns.gyroscopes)

    def with_gyroscopes(self) -> 'ArrayRecording':
        """Return the same recording; angular velocities beside accelerations take part."""
        if not self._has_gyroscopes:
            return self
        return self.again(options=replace(self.read_from.options, gyroscopes=True))

    def again(self, **changes: Any) -> 'ArrayRecording':
        """Return the same recording with some of what it was made from replaced."""
        source = replace(self.read_from, **changes)
        return ArrayRecording(self.path, *(getattr(source, it.name) for it in fields(source)))

    def attachments(self) -> tuple[Attachment, ...]:
        """Return none: arrays carry no files."""
        return ()

    def info(self) -> RecordingInfo:
        """Return what the file holds."""
        return summarise(
            self, path=str(self.path), kind=self.kind, entries=(), damage=(), notes=self.notes
        )

    def measurements(self) -> Iterator[Measurement]:
        """Yield the samples in stretches of a quarter of a second, joint states behind them."""
        step = max(FEWEST_ROWS, round(BLOCK_S * self.sample_rate_hz))
        pages = ReadPages.behind(self._values)
        for first in range(0, len(self._values), step):
            self.fraction_read = min(1.0, (first + step) / len(self._values))
            piece = np.asarray(self._values[first : first + step], dtype=np.float64)
            rows = np.ascontiguousarray(piece[:, self._columns]) * self._scale
            pages.read(piece.nbytes)
            # Where nothing at all was recorded its channels are told, and no pause.
            for part in [slice(0, len(rows))] if self._is_empty else _recorded(rows):
                yield self._block(first + part.start, rows[part])
            if self._joints is not None:
                stamps = self._clock.row_stamps_ns(len(rows), first)
                yield self._joints.samples(stamps, slice(first, first + len(rows)))

    def _block(self, first: int, rows: NDArray[np.float64]) -> Measurement:
        if self.stamp_ns is None:
            offset = round(first * NANOSECONDS_PER_SECOND / self.sample_rate_hz)
            return SampleBlock(
                source=self.source,
                stamp_ns=self.start_ns + offset,
                first_index=first,
                sample_rate_hz=self.sample_rate_hz,
                channel_names=self.channel_names,
                acceleration=rows,  # type: ignore[arg-type]
                units=self.units,
            )
        return StampedSamples(
            source=self.source,
            frame_id='',
            stamp_ns=self.stamp_ns[first : first + len(rows)],
            acceleration=rows,
            channel_names=self.channel_names,
            units=self.units,
        )

    def row_stamps_ns(self) -> NDArray[np.int64]:
        """Return the time of every row, (n_rows,) [ns]."""
        return self._clock.row_stamps_ns(len(self._values))

    def spindle_speed(self) -> SpindleSpeed | None:
        """Return the speed of the spindle; None where no column of it is named."""
        if self._speed_hz is None:
            return None
        return SpindleSpeed.of(self.row_stamps_ns(), self._speed_hz)

    def damage(self) -> tuple[str, ...]:
        """Return nothing: a plain array is read whole or refused."""
        return ()


def _recorded(rows: NDArray[np.float64]) -> list[slice]:
    """Return the stretches of rows with any number: where a recorder paused there is none.

    Of one channel alone a value that is lost and a pause look alike: it is lost.
    """
    paused = np.isnan(rows).all(axis=1)
    if rows.shape[1] == 1 or not paused.any():
        return [slice(0, len(rows))]
    edges = np.flatnonzero(np.diff(np.concatenate([[True], paused, [True]])))
    return [slice(int(a), int(b)) for a, b in edges.reshape(-1, 2)]


def _n_lost(values: NDArray[np.generic], columns: ArrayColumns) -> NDArray[np.int64]:
    """Return how many values of each channel are no numbers."""
    lost = np.zeros(len(columns.channels), dtype=np.int64)
    if values.dtype.kind != 'f':
        return lost
    pages = ReadPages.behind(values)
    for first in range(0, len(values), ROWS_AT_ONCE):
        part = values[first : first + ROWS_AT_ONCE]
        pages.read(part.nbytes)
        lost += np.sum(~np.isfinite(part[:, columns.channels]), axis=0)
    return lost


def _told(n_lost: NDArray[np.int64], columns: ArrayColumns) -> tuple[str, ...]:
    """Say how many values are no numbers, as loggers write what they did not get."""
    found = [f'{n} of {name}' for n, name in zip(n_lost, columns.names, strict=True) if n]
    said = ', '.join(found[:MOST_NAMED]) + ', ...' * (len(found) > MOST_NAMED)
    return (f'values that are no numbers, taken as lost: {said}',) if found else ()
