"""Which columns of a table are accelerations, in which unit, and which are times or counters."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import RecordingError
from modal_recordings.array_options import ArrayOptions
from modal_recordings.array_table import ArrayTable
from modal_recordings.counting import counts_up
from modal_recordings.heading import Heading, heading_of
from modal_recordings.units import to_si

LEAVE_OUT = '-'


@dataclass(frozen=True, slots=True)
class ArrayColumns:
    """What the columns of a table are.

    Parameters
    ----------
    channels : tuple of int
        Columns of acceleration.
    names : tuple of str
        Of the channels.
    scale : (n_channels,) array
        From the file's units to m/s².
    times : tuple of int
        Columns of time.
    time_factors : tuple of float or None
        To seconds; None where no unit is stated.
    counter : int or None
        Column that numbers the rows.
    notes : tuple of str
        What was assumed, and what is left out.
    """

    channels: tuple[int, ...]
    names: tuple[str, ...]
    scale: NDArray[np.float64]
    times: tuple[int, ...] = ()
    time_factors: tuple[float | None, ...] = ()
    counter: int | None = None
    notes: tuple[str, ...] = ()


def array_columns(path: Path, table: ArrayTable, options: ArrayOptions) -> ArrayColumns:
    """Tell what every column is, from its heading, the options and whether it counts up.

    Raises
    ------
    RecordingError
        A column may be several things, units contradict one another, or no acceleration is left.
    """
    headings = _headings(path, table, options)
    times, counters, channels, notes = [], [], [], []
    for column, heading in enumerate(headings):
        if heading is None:
            continue
        if column in table.dated or heading.is_time:
            times.append(column)
        elif heading.is_other and (heading.unit is not None):
            notes.append(
                f'{_called(heading, column)} left out: {heading.unit_text}, no acceleration'
            )
        elif counts_up(table.values[:, column]):
            if not heading.is_counter:
                raise _ask(path, column, heading, 'counts up: a time or a counter?', options)
            counters.append(column)
            notes.append(f'{_called(heading, column)} left out: counts the rows')
        elif heading.is_other and not options.channels:
            raise _ask(path, column, heading, 'an acceleration? its unit is not stated', options)
        else:
            channels.append(column)
    known = [heading or Heading('') for heading in headings]
    if not channels:
        units = ', '.join(sorted({heading.unit_text for heading in known} - {''}))
        raise RecordingError(
            'no column of acceleration',
            where=path,
            found=units or None,
            advice=options.advice.columns,
        )
    named = _named(path, [known[column] for column in channels], options, len(headings))
    scale, assumed = _scale(path, named, options)
    return ArrayColumns(
        channels=tuple(channels),
        names=tuple(heading.name for heading in named),
        scale=scale,
        times=tuple(times),
        time_factors=tuple(_time_factor(known[c], c in table.dated) for c in times),
        counter=counters[0] if counters else None,
        notes=(*assumed, *notes),
    )


def _time_factor(heading: Heading, dated: bool) -> float | None:
    if dated:
        return 1.0
    return None if heading.unit is None else heading.unit.factor


def _headings(path: Path, table: ArrayTable, options: ArrayOptions) -> list[Heading | None]:
    """Return the heading of every column, the given name over the file's; None: left out."""
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
            'channel named twice', where=f'{path}: channels', found=', '.join(names)
        )
    return named


def _told(path: Path, name: str, own: Heading) -> Heading:
    """Return a heading as given; a name alone does not unsay the unit that the file states."""
    told = heading_of(name, '', f'{path}: channels')
    return told if told.unit else replace(own, name=told.name)


def _scale(
    path: Path, headings: Sequence[Heading], options: ArrayOptions
) -> tuple[NDArray[np.float64], tuple[str, ...]]:
    """Return the factor of every channel to m/s², and what was assumed."""
    stated = [heading.unit.factor if heading.unit else None for heading in headings]
    if options.unit is not None:
        factor = to_si(options.unit, f'{path}: unit')
        other = next((h for h in headings if h.unit and h.unit.factor != factor), None)
        if other is not None:
            raise RecordingError(
                'units contradict one another',
                where=f'{path}: column {other.name}',
                found=f'{other.unit_text} in the file',
                expected=f'{options.unit} as given',
            )
        return np.full(len(headings), factor), ()
    if all(factor is None for factor in stated):
        return np.ones(len(headings)), ('no unit stated: taken as m/s^2',)
    missing = next((h for h, factor in zip(headings, stated, strict=True) if factor is None), None)
    if missing is not None:
        raise RecordingError(
            'no unit, where others have one',
            where=f'{path}: column {missing.name}',
            expected=f'a unit for every column, or {options.advice.unit} for those without',
            advice=options.advice.columns,
        )
    return np.array(stated, dtype=float), ()


def _called(heading: Heading, column: int) -> str:
    return heading.name or f'column {column + 1}'


def _ask(
    path: Path, column: int, heading: Heading, what: str, options: ArrayOptions
) -> RecordingError:
    name = f' ({heading.name})' if heading.name else ''
    place = f'{path}: column {column + 1}{name}'
    return RecordingError(what, where=place, advice=options.advice.columns)
