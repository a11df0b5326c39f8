"""A mark in a recording: a channel that is high while the robot shakes itself.

A digital output of the robot's controller, wired to a channel of the data logger, tells when the
motion begins and ends on the logger's own clock.  The recording is cut to it: its first sample is
the plan's beginning, whatever the clocks say.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import RecordingError
from modal_core.measurements import (
    JointSamples,
    Measurement,
    NANOSECONDS_PER_SECOND,
    SampleBlock,
    StampedSamples,
)
from modal_core.units import WITH_UNIT
from modal_recordings.tables import ArrayTable

LOW, HIGH = 0.3, 0.7
"""Of the way from the lowest to the highest value: a level is left beyond the other one."""
MOST_BETWEEN = 0.02
"""Share of samples between the two: noise of any kind alone has most of them there, two levels
with Gaussian noise reach it where they are 10 deviations of the noise apart (minimum and maximum
of a million samples then lie 5 deviations outside each)."""
Piece = tuple[NDArray[np.int64], NDArray[np.float64]]
Pieces = Callable[[], Iterable[Piece]]


@dataclass(frozen=True, slots=True)
class Stretch:
    """Where a mark is high.

    Parameters
    ----------
    first, last : int
        Place of the first and of the last sample.
    """

    first: int
    last: int


def high_stretch(pieces: Pieces, name: str, where: object) -> Stretch:
    """Return where a mark is high; it is read twice, and nothing of it is kept.

    Parameters
    ----------
    pieces : callable
        Returns the places and values of the mark, in order.
    name, where
        What to call the mark and its recording.

    Raises
    ------
    RecordingError
        It has not two levels, is never high, or several times.
    """
    low, high = np.inf, -np.inf
    for _, values in pieces():
        finite = values[np.isfinite(values)]
        if len(finite):
            low, high = min(low, float(finite.min())), max(high, float(finite.max()))
    if not high > low:
        raise RecordingError('the mark never changes', where=where, found=name)
    stretches, n_between, n_samples = _stretches(pieces, low, high)
    if n_between > MOST_BETWEEN * n_samples:
        raise RecordingError(
            'no mark: it has not two levels', where=where, found=name,
            expected=f'at most {MOST_BETWEEN:.0%} of the samples between them',
        )  # fmt: skip
    if len(stretches) != 1:
        raise RecordingError(
            'the mark is high several times', where=where, found=f'{name}: {len(stretches)} times',
            expected='once', advice='cut the recording',
        )  # fmt: skip
    return stretches[0]


def _stretches(pieces: Pieces, low: float, high: float) -> tuple[list[Stretch], int, int]:
    """Return every stretch above the upper threshold until below the lower one, and counts."""
    down, up = low + LOW * (high - low), low + HIGH * (high - low)
    found: list[Stretch] = []
    first = last = -1
    n_between = n_samples = 0
    for places, values in pieces():
        n_samples += len(values)
        n_between += int(np.count_nonzero((values > down) & (values < up)))
        high_rows = np.flatnonzero(values >= up)
        for row, above in _turns(values, down, up):
            before = int(np.searchsorted(high_rows, row))
            last = int(places[high_rows[before - 1]]) if before else last
            if above and first < 0:
                first = int(places[row])
            elif not above and first >= 0:
                found.append(Stretch(first, last))
                first = -1
        last = int(places[high_rows[-1]]) if len(high_rows) else last
    if first >= 0:
        found.append(Stretch(first, last))
    return found, n_between, n_samples


def _turns(values: NDArray[np.float64], down: float, up: float) -> Iterator[tuple[int, bool]]:
    """Yield the rows where values go above the upper or below the lower threshold, in order."""
    level = np.where(values >= up, 1, np.where(values <= down, -1, 0))
    known = np.flatnonzero(level)
    changed = known[np.concatenate([[True], np.diff(level[known]) != 0])] if len(known) else known
    for row in changed:
        yield int(row), bool(level[row] > 0)


def mark_pieces(measurements: Callable[[], Iterable[Measurement]], name: str) -> Pieces:
    """Return the times [ns] and values of the channel of a name, however often it is read."""

    def pieces() -> Iterator[Piece]:
        for item in measurements():
            if isinstance(item, JointSamples) or name not in item.channel_names:
                continue
            column = item.acceleration[:, item.channel_names.index(name)]
            yield _times(item), np.asarray(column, np.float64)

    return pieces


def cut(item: Measurement, stretch: Stretch, name: str) -> Measurement | None:
    """Return what of a measurement lies in a stretch [ns], without the mark; None for nothing."""
    inside = (_times(item) >= stretch.first) & (_times(item) <= stretch.last)
    if not inside.any():
        return None
    rows = slice(int(np.argmax(inside)), len(inside) - int(np.argmax(inside[::-1])))
    if isinstance(item, JointSamples):
        parts: dict[str, Any] = {
            field: getattr(item, field)[rows] for field in ('stamp_ns', 'position', 'velocity')
        }
        return replace(
            item, **parts, effort=item.effort[rows] if item.effort.size else item.effort
        )
    kept = [index for index, one in enumerate(item.channel_names) if one != name]
    if item.channel_names and not kept:
        return None
    columns = kept if item.channel_names else slice(None)
    changed: dict[str, Any] = {
        'acceleration': item.acceleration[rows][:, columns],
        'channel_names': tuple(item.channel_names[index] for index in kept),
        'units': tuple(item.units[index] for index in kept) if item.units else (),
    }
    if isinstance(item, SampleBlock):
        first = rows.start
        step_ns = NANOSECONDS_PER_SECOND / item.sample_rate_hz
        return replace(
            item, **changed, stamp_ns=item.stamp_ns + round(first * step_ns),
            first_index=item.first_index + first,
        )  # fmt: skip
    turning = item.angular_velocity
    return replace(
        item, **changed, stamp_ns=item.stamp_ns[rows],
        angular_velocity=None if turning is None else turning[rows],
    )  # fmt: skip


def _times(item: Measurement) -> NDArray[np.int64]:
    """Return the time of every sample [ns]."""
    if isinstance(item, StampedSamples | JointSamples):
        return item.stamp_ns
    steps = np.arange(len(item.acceleration)) * (NANOSECONDS_PER_SECOND / item.sample_rate_hz)
    return item.stamp_ns + np.round(steps).astype(np.int64)


def marked_table(table: ArrayTable, name: str, where: object) -> tuple[ArrayTable, str]:
    """Return the rows of a table while a column is high, and what was cut, in words.

    Raises
    ------
    RecordingError
        No such column, or it is no mark.
    """
    plain = [WITH_UNIT.sub(r'\1', heading).strip() for heading in table.headings]
    if name not in plain:
        raise RecordingError(
            'no such column for the mark', where=where, found=name,
            expected=', '.join(plain) or 'a file with headings',
        )  # fmt: skip
    number = plain.index(name)
    column = table.column(number)
    rows = np.arange(len(column))
    stretch = high_stretch(lambda: [(rows, column)], name, where)
    headings, units = list(table.headings), list(table.units)
    # What is measured in volts is no response, and is left out as such.
    headings[number] = f'{name} [V]'
    if units:
        units[number] = 'V'
    note = f'mark {name}: rows {stretch.first + 1} to {stretch.last + 1} of {len(rows)} are used'
    values = table.values[stretch.first : stretch.last + 1]
    return replace(table, values=values, headings=tuple(headings), units=tuple(units)), note
