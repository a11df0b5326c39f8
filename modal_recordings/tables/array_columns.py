"""Which columns of a table are responses, in which unit, and which are times or counters."""

from collections.abc import Container, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
import re

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import RecordingError
from modal_core.units import (
    ACCELERATION,
    ANGULAR_VELOCITY,
    KINDS,
    response_unit,
    STANDARD_GRAVITY,
    Unit,
)
from modal_core.words.named import named
from modal_recordings.tables.array_options import ArrayOptions
from modal_recordings.tables.array_table import ArrayTable
from modal_recordings.tables.counting import counts_up
from modal_recordings.tables.heading import Heading, heading_of
from modal_recordings.tables.joint_headings import is_of_joints

LEAVE_OUT = '-'
LAST_G = re.compile(r'\w[\s_]g$')
NO_UNIT = 'no unit stated: taken as m/s^2'
IN_G = 'no unit but in the names, which all end in g: taken as g'


@dataclass(frozen=True, slots=True)
class ArrayColumns:
    """What the columns of a table are.

    Parameters
    ----------
    channels : tuple of int
        Columns of responses.
    names : tuple of str
        Of the channels.
    scale : (n_channels,) array
        From the file's units to SI units.
    units : tuple of str
        Those SI units.
    times : tuple of int
        Columns of time.
    time_factors : tuple of float or None
        To seconds; None where no unit is stated.
    counter : int or None
        Column that numbers the rows.
    notes : tuple of str
        What is left out.
    assumed : tuple of str
        Units that nobody stated, and what may surprise of those stated.
    gyroscopes : int
        Columns of gyroscopes that are left out, being beside accelerometers.
    units_told : bool
        Whether somebody stated the units.
    """

    channels: tuple[int, ...]
    names: tuple[str, ...]
    scale: NDArray[np.float64]
    units: tuple[str, ...]
    times: tuple[int, ...] = ()
    time_factors: tuple[float | None, ...] = ()
    counter: int | None = None
    notes: tuple[str, ...] = ()
    assumed: tuple[str, ...] = ()
    gyroscopes: int = 0
    units_told: bool = True


def array_columns(
    path: Path, table: ArrayTable, options: ArrayOptions, *, may_have_none: bool = False
) -> ArrayColumns:
    """Tell what every column is, from its heading, the options and whether it counts up.

    Parameters
    ----------
    path : Path
        Named in errors.
    table : ArrayTable
        Of all columns.
    options : ArrayOptions
        What the file does not say itself.
    may_have_none : bool
        Whether a table without any response is no error.

    Raises
    ------
    RecordingError
        A column may be several things, units contradict one another, or no response is left.
    """
    headings = table_headings(path, table, options)
    beside = () if options.channels or options.gyroscopes else _turns_beside(headings)
    of_joints = {} if options.channels else _joints_beside(headings)
    has_time = bool(table.dated) or any(heading and heading.is_time for heading in headings)
    times, counters, channels, notes = [], [], [], []
    for column, heading in enumerate(headings):
        if heading is None or column == table.speed:
            continue
        if column in table.dated or heading.is_time:
            times.append(column)
        elif heading.is_other and (heading.unit is not None):
            notes.append(f'{_called(heading, column)} left out: {heading.unit_text}, no response')
        elif column in of_joints:
            notes += of_joints[column]
        elif column in beside:
            notes.append(
                f'{_called(heading, column)} left out: {heading.unit_text} beside accelerations;'
                ' taken where columns are named or gyroscopes are asked for'
            )
        elif counts_up(table.values[:, column]):
            if not heading.is_counter and not (
                has_time and not heading.name and _counts_rows(table.column(column))
            ):
                raise _ask(path, column, heading, 'counts up: a time or a counter?', options)
            counters.append(column)
            notes.append(f'{_called(heading, column)} left out: counts the rows')
        elif heading.is_other and not options.channels:
            raise _ask(path, column, heading, 'an acceleration? its unit is not stated', options)
        else:
            channels.append(column)
    known = [heading or Heading('') for heading in headings]
    if not channels and not may_have_none:
        units = ', '.join(sorted({heading.unit_text for heading in known} - {''}))
        raise RecordingError(
            'no column of responses',
            where=path,
            found=units or None,
            advice=options.advice.columns,
        )
    responses = _named(path, [known[column] for column in channels], options, len(headings))
    is_told = options.unit is not None or any(heading.unit for heading in responses)
    if channels and not table.calibrated and not is_told:
        raise RecordingError(
            'not calibrated: values are shares of full scale',
            where=path,
            found=_size(table, len(channels)),
            expected=f"what full scale is: {options.advice.unit} '50 m/s^2'",
        )
    measured_in, assumed = _units(path, responses, options) if responses else ([], ())
    return ArrayColumns(
        channels=tuple(channels),
        names=tuple(heading.name for heading in responses),
        scale=np.array([unit.factor for unit in measured_in], dtype=float),
        units=tuple(unit.si for unit in measured_in),
        times=tuple(times),
        time_factors=tuple(_time_factor(known[c], c in table.dated) for c in times),
        counter=counters[0] if counters else None,
        notes=tuple(notes),
        assumed=assumed,
        gyroscopes=len(beside),
        units_told=NO_UNIT not in assumed,
    )


def _size(table: ArrayTable, n_channels: int) -> str:
    """Say how much there is of what cannot be read yet."""
    n_samples, rate_hz = len(table.values), table.sample_rate_hz
    size = f'{n_channels} channels of {n_samples} samples'
    return size if rate_hz is None else f'{size} at {rate_hz:g} Hz: {n_samples / rate_hz:.5g} s'


def _counts_rows(values: NDArray[np.float64]) -> bool:
    """Tell whether a column has the numbers of the rows, as tables of pandas do."""
    return bool(values[0] in (0.0, 1.0) and np.all(np.diff(values) == 1.0))


def _turns_beside(headings: Sequence[Heading | None]) -> tuple[int, ...]:
    """Return the columns of gyroscopes beside those of accelerometers: most loggers write both."""
    measured = [heading.unit.si if heading and heading.unit else '' for heading in headings]
    if ACCELERATION not in measured:
        return ()
    return tuple(column for column, si in enumerate(measured) if si == ANGULAR_VELOCITY)


def _joints_beside(headings: Sequence[Heading | None]) -> dict[int, tuple[str, ...]]:
    """Return the columns without a unit called as what joints do; the first has a note of all."""
    others = [heading for heading in headings if heading is not None and not heading.is_time]
    found = {
        column: heading.name
        for column, heading in enumerate(headings)
        if heading is not None and heading.unit is None and is_of_joints(heading.name)
    }
    if not 0 < len(found) < len(others):
        return {}
    called = named(list(found.values()))
    note = f'{called} left out: what joints do, used where the robot is named'
    return dict.fromkeys(found, ()) | {next(iter(found)): (note,)}


def _time_factor(heading: Heading, dated: bool) -> float | None:
    if dated:
        return 1.0
    return None if heading.unit is None else heading.unit.factor


def without_columns(
    table: ArrayTable, options: ArrayOptions, columns: Container[int]
) -> tuple[ArrayTable, ArrayOptions]:
    """Return table and options without some columns, which something else is read from."""
    n_columns = table.values.shape[1]
    others = [n for n in range(n_columns) if n not in columns]
    names = options.channels
    if names is not None and len(names) == n_columns:
        options = replace(options, channels=tuple(names[n] for n in others))
    return table.of_columns(others), options


def table_headings(path: Path, table: ArrayTable, options: ArrayOptions) -> list[Heading | None]:
    """Return the heading of every column, the given name over the file's; None: left out.

    Raises
    ------
    RecordingError
        A name is too long, or a unit is one nobody knows.
    """
    n_columns = table.values.shape[1]
    cells = table.headings or ('',) * n_columns
    units = table.units or ('',) * n_columns
    given = options.channels
    if given is None or len(given) != n_columns:
        return [_heading(path, n, cells[n], units[n]) for n in range(n_columns)]
    return [
        None if name == LEAVE_OUT else _told(path, name, _heading(path, n, cells[n], units[n]))
        for n, name in enumerate(given)
    ]


def _heading(path: Path, column: int, cell: str, unit: str) -> Heading:
    return heading_of(cell, unit, f'{path}: column {column + 1}')


def _named(
    path: Path, headings: Sequence[Heading], options: ArrayOptions, n_columns: int
) -> list[Heading]:
    """Return the headings of the channels, each with a name of its own."""
    given = options.channels
    if given is not None and len(given) not in (n_columns, len(headings)):
        raise RecordingError(
            'wrong number of channel names',
            where=f'{path}: channels',
            found=len(given),
            expected=f'{len(headings)}, one per column',
        )
    if given is not None and len(given) != n_columns:
        headings = [_told(path, name, own) for name, own in zip(given, headings, strict=True)]
    named = [replace(h, name=h.name or f'ch{n + 1}') for n, h in enumerate(headings)]
    names = [heading.name for heading in named]
    if len(set(names)) != len(names):
        raise RecordingError(
            'channel named twice',
            where=f'{path}: channels',
            found=', '.join(names),
            advice=options.advice.columns,
        )
    return named


def _told(path: Path, name: str, own: Heading) -> Heading:
    """Return a heading as given; a name alone does not unsay the unit that the file states."""
    told = heading_of(name, '', f'{path}: channels')
    return told if told.unit else replace(own, name=told.name)


def _units(
    path: Path, headings: Sequence[Heading], options: ArrayOptions
) -> tuple[list[Unit], tuple[str, ...]]:
    """Return the unit of every channel, and what was assumed or may surprise."""
    stated = [heading.unit for heading in headings]
    if options.unit is not None:
        given = response_unit(options.unit, f'{path}: unit', RecordingError)
        other = next((h for h in headings if h.unit and h.unit != given), None)
        if other is not None:
            raise RecordingError(
                'units contradict one another',
                where=f'{path}: column {other.name}',
                found=f'{other.unit_text} in the file',
                expected=f'{options.unit} as given',
            )
        return [given] * len(headings), ()
    if all(unit is None for unit in stated):
        if all(LAST_G.search(heading.name) for heading in headings):
            return [Unit(ACCELERATION, STANDARD_GRAVITY)] * len(headings), (IN_G,)
        return [Unit(ACCELERATION)] * len(headings), (NO_UNIT,)
    missing = next((h for h in headings if h.unit is None), None)
    if missing is not None:
        raise RecordingError(
            'no unit, where others have one',
            where=f'{path}: column {missing.name}',
            expected=f'a unit for every column, or {options.advice.unit} for those without',
            advice=options.advice.columns,
        )
    return [unit for unit in stated if unit is not None], _kinds_told(headings)


def _kinds_told(headings: Sequence[Heading]) -> tuple[str, ...]:
    """Name the channels that measure no acceleration."""
    return tuple(
        f'{heading.name} measures {KINDS[heading.unit.si]} [{heading.unit_text}]'
        for heading in headings
        if heading.unit is not None and heading.unit.si != ACCELERATION
    )


def _called(heading: Heading, column: int) -> str:
    return heading.name or f'column {column + 1}'


def _ask(
    path: Path, column: int, heading: Heading, what: str, options: ArrayOptions
) -> RecordingError:
    name = f' ({heading.name})' if heading.name else ''
    place = f'{path}: column {column + 1}{name}'
    return RecordingError(what, where=place, advice=options.advice.columns)
