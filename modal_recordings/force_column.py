"""The force of a hammer beside the responses of a table."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import RecordingError
from modal_core.units import STANDARD_GRAVITY, WITH_UNIT
from modal_recordings.array_recording import ArrayRecording
from modal_recordings.formats import read_arrays, READERS, table_of
from modal_recordings.open_recording import ARRAY_READERS, kind_of
from modal_recordings.tables import (
    array_options,
    ArrayOptions,
    ArrayTable,
    Heading,
    heading_of,
    without_columns,
)

NEWTONS = {
    'N': 1.0,
    'mN': 1e-3,  # however it is written: no hammer has meganewtons
    'daN': 10.0,
    'kN': 1e3,
    'kgf': STANDARD_GRAVITY,
    'gf': 1e-3 * STANDARD_GRAVITY,
    'lbf': 0.45359237 * STANDARD_GRAVITY,
}
FORCE_WORDS = frozenset(('force', 'hammer', 'kraft', 'impact'))
WITH_FORCE = ', '.join((*ARRAY_READERS, *READERS))
UNEVEN = 0.1
"""Share of a step by which a stamp may be off before the rows are no even samples."""
SHORTEST_RUN = 64
"""Rows of a run in the mean: fewer hold no ring-down: such stamps are uneven."""


@dataclass(frozen=True, slots=True)
class ForceRecording:
    """A table of responses with a force.

    Parameters
    ----------
    responses : ArrayRecording
        The other columns.
    force_n : (n_samples,) array [N]
        One value per row.
    name : str
        Of the force's column, without its unit.
    begins : tuple of int
        Rows where the times begin anew: runs of a trigger, or lost samples before them.
    without_unit : tuple of str
        Whose unit nobody stated: newtons and m/s² were taken.
    """

    responses: ArrayRecording
    force_n: NDArray[np.float64]
    name: str
    begins: tuple[int, ...] = (0,)
    without_unit: tuple[str, ...] = ()


def open_with_force(
    path: str | Path,
    force: str | None = None,
    sample_rate_hz: float | None = None,
    unit: str | None = None,
    channels: Sequence[str] | None = None,
    *,
    in_runs: bool = False,
) -> ForceRecording:
    """Open a table of which one column is a force.

    Parameters
    ----------
    path : path
        An array of any kind that has columns.
    force : str or None
        Name of the column; None: the one in newtons, or called a force or a hammer.
    sample_rate_hz, unit, channels
        See :func:`modal_recordings.open_recording`; names of all columns, the force among them.
    in_runs : bool
        Whether times may begin anew, as where a trigger starts a run of its own for each tap.

    Raises
    ------
    RecordingError
        No force, several, or a file whose columns are not told apart.
    """
    place = Path(path)
    suffix = kind_of(place)
    if not place.is_file() or suffix not in (*ARRAY_READERS, *READERS):
        raise RecordingError(
            'no table with a force channel',
            where=place,
            found='no such file' if not place.exists() else suffix or 'a folder',
            expected=f'a file of columns, one of them a force in N: {WITH_FORCE}',
        )
    options = array_options(place, sample_rate_hz, unit, channels)
    table = (
        ARRAY_READERS[suffix](place)
        if suffix in ARRAY_READERS
        else table_of(place, read_arrays(place, suffix), with_force=True)
    )
    headings = _headings(place, table, options)
    column = _force_column(place, headings, force)
    told = _told_unit(headings[column])
    factor = _newtons(place, told)
    rest = without_columns(table, options, {column})
    responses = ArrayRecording(place, *rest)
    begins = _begins(responses) if in_runs else (0,)
    _check_even(place, responses, begins)
    name = headings[column].name
    stated = (('the force', told), ('the responses', responses.units_told))
    without = tuple(whose for whose, unit in stated if not unit)
    return ForceRecording(responses, factor * table.column(column), name, begins, without)


def _headings(place: Path, table: ArrayTable, options: ArrayOptions) -> list[Heading]:
    n_columns = table.values.shape[1]
    cells = table.headings or ('',) * n_columns
    units = table.units or ('',) * n_columns
    if options.channels is not None and len(options.channels) == n_columns:
        cells = options.channels
    return [
        heading_of('' if cell == '-' else cell, unit, f'{place}: column {number + 1}')
        for number, (cell, unit) in enumerate(zip(cells, units, strict=True))
    ]


def _force_column(place: Path, headings: Sequence[Heading], force: str | None) -> int:
    known = ', '.join(heading.name for heading in headings if heading.name) or 'columns unnamed'
    if force is not None:
        named = [n for n, heading in enumerate(headings) if heading.name == force]
        if len(named) != 1:
            raise RecordingError('no such column', where=place, found=force, expected=known)
        return named[0]
    forces = [n for n, heading in enumerate(headings) if _is_force(heading)]
    if len(forces) == 1:
        return forces[0]
    raise RecordingError(
        'no force channel' if not forces else 'several force channels',
        where=place,
        found=known if not forces else ', '.join(headings[n].name for n in forces),
        expected='one column in N',
        advice='name it with --force, or its unit with --channels "force [N],a,b"',
    )


def _is_force(heading: Heading) -> bool:
    if heading.unit_text:
        return _known_factor(heading.unit_text) is not None
    return bool(heading.words) and heading.words[0] in FORCE_WORDS


def _known_factor(unit: str) -> float | None:
    return {name.lower(): factor for name, factor in NEWTONS.items()}.get(unit.strip().lower())


def _told_unit(heading: Heading) -> str:
    return heading.unit_text or (WITH_UNIT.match(heading.name) or ('', '', ''))[2]


def _newtons(place: Path, told: str) -> float:
    """Return the factor to newtons; a column without a unit is taken as newtons."""
    factor = _known_factor(told) if told else 1.0
    if factor is None:
        raise RecordingError(
            'unknown unit of a force', where=place, found=told, expected=', '.join(NEWTONS)
        )
    return factor


def _begins(responses: ArrayRecording) -> tuple[int, ...]:
    if responses.stamp_ns is None:
        return (0,)
    step_ns = 1e9 / responses.sample_rate_hz
    breaks = 1 + np.flatnonzero(np.abs(np.diff(responses.stamp_ns) - step_ns) > 0.5 * step_ns)
    return (0, *breaks.tolist()) if SHORTEST_RUN * len(breaks) < len(responses.stamp_ns) else (0,)


def _check_even(place: Path, responses: ArrayRecording, begins: Sequence[int]) -> None:
    if responses.stamp_ns is None:
        return
    step_ns = 1e9 / responses.sample_rate_hz
    for stamps in np.split(responses.stamp_ns, begins[1:]):
        n_rows = len(stamps)
        off = stamps - stamps[0] - step_ns * np.arange(n_rows)
        if np.abs(off).max() > UNEVEN * step_ns * max(1.0, 1e-3 * n_rows):
            raise RecordingError(
                'times are not even',
                where=place,
                found=f'{np.abs(off).max() / 1e6:.3g} ms off a rate of'
                f' {responses.sample_rate_hz:.6g} Hz',
                expected='force and responses of one converter, no sample lost',
            )
