"""When the rows of a plain array were taken: a stated rate, a column of times, or both."""

from dataclasses import dataclass
import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import RecordingError
from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_recordings.tables.array_columns import ArrayColumns
from modal_recordings.tables.array_options import ArrayOptions, HIGHEST_RATE_HZ, LOWEST_RATE_HZ
from modal_recordings.tables.array_table import ArrayTable
from modal_recordings.tables.row_period import (
    evenly_shared_s,
    MADE_UP_ROWS,
    row_period_s,
    shared_period_s,
    unpaused,
)
from modal_recordings.tables.time_columns import combined, past_midnight, which_time

RATE_TOLERANCE = 1e-3
"""Beyond it a stated rate and the times contradict one another: quartz clocks differ by 1e-4,
and natural frequencies would be off by as much."""
SLOWEST_S, FASTEST_S = 0.1, 1e-6
"""Steps of a time without unit that can only be seconds: below 10 Hz nothing of an arm is
recorded, whole milliseconds or rows are; above 1 MHz it is days."""
LEAST_EVEN = 0.5
"""Share of steps within half a step of the usual one; below, rows were not taken evenly."""

EVEN_ROWS = 2.5
"""Rows by which those that share a time may be more or fewer in all: a clock that rounds makes
one, a rate that is no whole number of rows another.  Of 2,343 made columns that lost none, times
off by up to half a row, 0.9 % come out beyond it (seed 8200); of those that lost 1, 2 or 3 rows at
once 89, 13 and 0.1 % within: a row or two out of place."""
LONGEST_SHARED_S = 0.25
"""Gaps that the identifier fills at most (its ``longest_filled_s``, with what they cost there);
rows lost within a longer time could not be placed."""
COARSE_TICK = 1.5
"""Steps of the stated rate between different times from where on several rows share a time."""


@dataclass(frozen=True, slots=True)
class ArrayClock:
    """Times of the rows.

    Parameters
    ----------
    sample_rate_hz : float [Hz]
        Of the rows.
    stamp_ns : (n_samples,) array [ns] or None
        None: the rows are a uniform clock from ``start_ns``.
    start_ns : int [ns]
        Of the first row.
    notes : tuple of str
        What was assumed.
    """

    sample_rate_hz: float
    stamp_ns: NDArray[np.int64] | None
    start_ns: int
    notes: tuple[str, ...] = ()

    def row_stamps_ns(self, n_rows: int, first: int = 0) -> NDArray[np.int64]:
        """Return the times of rows from ``first`` on, (n_rows,) [ns]."""
        if self.stamp_ns is not None:
            return self.stamp_ns[first : first + n_rows]
        steps = np.arange(first, first + n_rows) * (NANOSECONDS_PER_SECOND / self.sample_rate_hz)
        return np.asarray(self.start_ns + np.round(steps).astype(np.int64))


def array_clock(
    path: Path, table: ArrayTable, columns: ArrayColumns, options: ArrayOptions
) -> ArrayClock:
    """Return when the rows were taken.

    Raises
    ------
    RecordingError
        Neither a rate nor times; times that do not run forward, or contradict the stated rate.
    """
    stated_hz = _stated_hz(path, table, options)
    time_s = _time_s(path, table, columns, options.advice.columns)
    notes: tuple[str, ...] = ()
    if time_s is None and stated_hz is not None:
        time_s = _counted_s(table, columns, stated_hz)
    if time_s is None:
        if stated_hz is None:
            raise RecordingError(
                'no sample rate',
                where=f'{path}: sample_rate_hz',
                expected=options.advice.rate,
            )
        return ArrayClock(stated_hz, None, options.start_ns)
    measured_hz = _measured_hz(path, time_s, options.advice.columns)
    if None in columns.time_factors:
        notes = (f'time without unit: taken as seconds, {measured_hz:.6g} Hz',)
        _check_seconds(path, measured_hz, time_s, stated_hz, options.advice.columns)
    n_anew = int(np.count_nonzero(np.diff(time_s) < -MADE_UP_ROWS / measured_hz))
    if n_anew:
        notes += (f'time falls back {n_anew} x: what follows is a recording of its own',)
    if stated_hz is not None:
        _check_rate(path, stated_hz, measured_hz, len(time_s))
        if _is_uniform(time_s, stated_hz):
            return ArrayClock(stated_hz, None, options.start_ns, notes)
    elif _is_counted(path, time_s, measured_hz):
        parts = unpaused(time_s)
        n_pauses = len(parts) - 1 - n_anew
        time_s = evenly_shared_s(time_s, 1.0 / measured_hz, parts)
        pauses = f', with {n_pauses} {"pauses" if n_pauses > 1 else "pause"}' if n_pauses else ''
        notes += (
            f'several rows share each time: taken as evenly spaced{pauses}, {measured_hz:.6g} Hz',
        )
    stamps = _nanoseconds(path, time_s) + options.start_ns
    return ArrayClock(stated_hz or measured_hz, stamps, int(stamps[0]), notes)


def _stated_hz(path: Path, table: ArrayTable, options: ArrayOptions) -> float | None:
    given, own = options.sample_rate_hz, table.sample_rate_hz
    if given is not None and own is not None:
        _check_rate(path, given, own, len(table.values), 'above the table')
    return given if given is not None else own


def _check_rate(
    path: Path, stated_hz: float, found_hz: float, n_rows: int, where: str = 'by its times'
) -> None:
    if abs(found_hz / stated_hz - 1.0) > max(RATE_TOLERANCE, 1.0 / n_rows):
        raise RecordingError(
            'sample rates contradict one another',
            where=path,
            found=f'{found_hz:.6g} Hz {where}',
            expected=f'{stated_hz:.6g} Hz as stated',
        )


def _time_s(
    path: Path, table: ArrayTable, columns: ArrayColumns, advice: str
) -> NDArray[np.float64] | None:
    """Return the time of every row, of two columns their sum where one refines the other."""
    found: list[NDArray[np.float64]] = [
        table.column(column) * (factor or 1.0)
        for column, factor in zip(columns.times, columns.time_factors, strict=True)
    ]
    for time_s in found:
        if not np.isfinite(time_s).all():
            row = int(np.flatnonzero(~np.isfinite(time_s))[0])
            raise RecordingError('time is not finite', where=f'{path}: row {row + 1}')
    if len(found) == 2:
        found = [combined(path, found[0], found[1], advice)]
    if len(found) > 2:
        raise which_time(path, len(found), advice)
    if found and table.dated:
        return past_midnight(found[0])
    return found[0] if found else None


def _counted_s(
    table: ArrayTable, columns: ArrayColumns, rate_hz: float
) -> NDArray[np.float64] | None:
    """Return times from a counter that left rows out; None where it counts every one."""
    if columns.counter is None:
        return None
    count = table.column(columns.counter)
    steps = np.diff(count)
    step = float(np.median(steps))
    if step <= 0.0 or (steps < 0.0).any() or not (steps > 1.5 * step).any():
        return None
    return np.asarray((count - count[0]) / (step * rate_hz), dtype=np.float64)


def _measured_hz(path: Path, time_s: NDArray[np.float64], advice: str) -> float:
    """Return the rate of times, gaps left out, also where several rows share a stamp."""
    steps = np.diff(time_s)
    mean_s = float(time_s[-1] - time_s[0]) / len(steps)
    usual_s = float(np.median(steps))
    near = np.abs(steps - usual_s) <= 0.5 * usual_s
    if mean_s <= 0.0 or 2 * np.count_nonzero(steps < 0.0) > len(steps):
        raise RecordingError(
            'time column does not run forward',
            where=path,
            found=f'mean step {mean_s:g} s',
            expected='> 0 s',
        )
    if usual_s > 0.0:
        if np.count_nonzero(near) < LEAST_EVEN * len(steps) and not _is_coarse(steps):
            raise RecordingError(
                'rows not evenly spaced in time',
                where=path,
                found=f'steps {steps.min():.3g} to {steps.max():.3g} s',
                expected='a constant rate',
            )
        mean_s = row_period_s(time_s)
    else:
        mean_s = shared_period_s(time_s)[0] or mean_s
    rate_hz = 1.0 / mean_s
    if not math.isfinite(rate_hz) or not LOWEST_RATE_HZ <= rate_hz <= HIGHEST_RATE_HZ:
        raise RecordingError(
            'no possible sample rate',
            where=path,
            found=f'{rate_hz:.3g} Hz by its times',
            expected=f'{LOWEST_RATE_HZ:g} to {HIGHEST_RATE_HZ:g} Hz',
            advice=advice,
        )
    return rate_hz


def _is_coarse(steps: NDArray[np.float64]) -> bool:
    """Tell whether the steps are few whole multiples of the stamps' own resolution."""
    return len(np.unique(np.round(steps, 9))) <= 4


def _check_seconds(
    path: Path,
    measured_hz: float,
    time_s: NDArray[np.float64],
    stated_hz: float | None,
    advice: str,
) -> None:
    """Ask for the unit of times where they may well be no seconds."""
    step_s = 1.0 / measured_hz
    if stated_hz is not None and abs(measured_hz / stated_hz - 1.0) <= RATE_TOLERANCE:
        return
    whole = not np.any(np.mod(time_s[:1000], 1.0))
    if whole or not FASTEST_S <= step_s <= SLOWEST_S:
        raise RecordingError(
            'time without unit',
            where=path,
            found=f'steps of {step_s:.4g}',
            expected='s, ms, us or ns',
            advice=advice,
        )


def _is_uniform(time_s: NDArray[np.float64], rate_hz: float) -> bool:
    """Tell whether times are those of the rate, to their resolution: half a step, or a tick."""
    steps = np.diff(time_s)
    tick_s = float(np.min(steps, where=steps > 0.0, initial=np.inf))
    is_coarse = COARSE_TICK < tick_s * rate_hz < math.inf
    grid = time_s[0] + np.arange(len(time_s)) / rate_hz
    reach_s = tick_s if is_coarse else 0.5 / rate_hz
    return bool(np.abs(time_s - grid).max() <= reach_s)


def _is_counted(path: Path, time_s: NDArray[np.float64], rate_hz: float) -> bool:
    """Tell whether rows that share times follow one another evenly: none was lost.

    Raises
    ------
    RecordingError
        They do not, and share times for so long that what was lost cannot be told.
    """
    steps = np.diff(time_s)
    if float(np.median(steps)) > 0.0:
        return False
    if shared_period_s(time_s)[1] * rate_hz <= EVEN_ROWS:
        return True
    tick_s = float(np.median(steps[steps > 0.0]))
    if tick_s > LONGEST_SHARED_S:
        raise RecordingError(
            'rows share times, and not evenly many do',
            where=path,
            found=f'times {tick_s:.4g} s apart, {rate_hz * tick_s:.4g} rows each on average',
            expected='times of every row, or as many rows to each',
            advice='where no row is lost, state the sample rate and leave the times out',
        )
    return False


def _nanoseconds(path: Path, time_s: NDArray[np.float64]) -> NDArray[np.int64]:
    if np.abs(time_s).max() > 4e9:
        raise RecordingError(
            'time out of range', where=path, found=f'{time_s.max():g} s', expected='< 4e9 s'
        )
    # Whole seconds apart: a double holds nanoseconds only within a few days.
    whole = np.floor(time_s)
    nanoseconds = np.rint((time_s - whole) * NANOSECONDS_PER_SECOND)
    stamps = whole.astype(np.int64) * NANOSECONDS_PER_SECOND + nanoseconds.astype(np.int64)
    return np.asarray(stamps - min(0, int(stamps.min())), dtype=np.int64)
