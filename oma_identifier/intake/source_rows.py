"""Grid rows of one source in one piece, so that a window is a view of them and no copy."""

from dataclasses import dataclass, replace
import sys

import numpy as np
from numpy.typing import NDArray

from modal_core.work.free_memory import LARGE_BYTES
from oma_identifier.quality import joined, summarise, Summary
from oma_identifier.time_axis import GridRows

RESERVE = 1.25
"""Rows there is room for, in windows: each row is moved a few times while windows slide.  Of
large windows there is room for one only: memory counts more than moves."""
MOVED_AT_ONCE = 4096
DOUBLE: 'np.dtype[np.floating]' = np.dtype(np.float64)
OWN_REFERENCES = 4
"""To an array nobody looks at: by the rows, the tuple and the loop that ask, and the call."""


@dataclass(frozen=True, slots=True)
class _Part:
    """Rows as they came: where in them values were bad or mended, None for nowhere."""

    rows: range
    summary: Summary
    bad: NDArray[np.bool_] | None
    mended: NDArray[np.bool_] | None


@dataclass(frozen=True, slots=True)
class _Held:
    """Room for rows: ``values``, ``lost`` and ``filled`` as in :class:`GridRows`."""

    values: NDArray[np.floating]
    lost: NDArray[np.bool_]
    filled: NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class CutRows:
    """Rows of one source in one window.

    Parameters
    ----------
    values : (n_rows, n_channels) array [m/s²]
        As precise as the source sends; zero where lost; shared, not to be written to.
    lost, filled : (n_rows,) bool array
        As in :class:`GridRows`.
    bad : (n_channels,) bool array
        Where the source sent what is no number, for too long to fill.
    n_mended : (n_channels,) int array
        Rows of each channel that were filled in place of it.
    summary : Summary
        Of the values.
    """

    values: NDArray[np.floating]
    lost: NDArray[np.bool_]
    filled: NDArray[np.bool_]
    bad: NDArray[np.bool_]
    n_mended: NDArray[np.int64]
    summary: Summary


class SourceRows:
    """Keeps the rows of one source from one grid index on.

    Parameters
    ----------
    first_row : int
        Grid index of the first row.
    n_channels : int
        Columns.
    window_rows : int
        Length of the windows that are cut.
    dtype : numpy dtype
        Precision in which the source sends: what is interpolated between its samples is not known
        any better, and rounding in single precision is 1e-7 of it.
    """

    def __init__(
        self,
        first_row: int,
        n_channels: int,
        window_rows: int,
        dtype: 'np.dtype[np.floating]' = DOUBLE,
    ) -> None:
        large = window_rows * n_channels * dtype.itemsize >= LARGE_BYTES
        self._reserve = window_rows if large else int(RESERVE * window_rows)
        self._held = _room(0, n_channels, dtype)
        self._first = first_row
        self._end = first_row
        self._needed = first_row
        self._parts: list[_Part] = []

    @property
    def n_held(self) -> int:
        """Rows that are still needed."""
        return self._end - self._needed

    def append(self, rows: GridRows) -> None:
        """Add the next rows."""
        count = len(rows.lost)
        if self._end - self._first + count > len(self._held.lost):
            self._move(count)
        here = slice(self._end - self._first, self._end - self._first + count)
        for held, new in zip(_arrays(self._held), _arrays(rows), strict=True):
            held[here] = new
        own = range(self._end, self._end + count)
        bad, mended = (each if each.any() else None for each in (rows.bad, rows.mended))
        self._parts.append(_Part(own, self._summary(here), bad, mended))
        self._end = own.stop

    def _move(self, count: int) -> None:
        """Make room: in new arrays where windows that were cut still look at the old ones."""
        kept = slice(self._needed - self._first, self._end - self._first)
        room = max(self._reserve, self.n_held + count)
        old = self._held
        fits = room <= len(old.lost) and not _is_looked_at(old)
        new = old if fits else _room(room, old.values.shape[1], old.values.dtype)
        for array, before in zip(_arrays(new), _arrays(old), strict=True):
            for first in range(0, self.n_held, MOVED_AT_ONCE):
                last = min(first + MOVED_AT_ONCE, self.n_held)
                array[first:last] = before[kept][first:last]
        self._held = new
        self._first = self._needed

    def reach(self, end: int) -> None:
        """Fill up with lost rows."""
        if end > self._end:
            self.append(GridRows.nothing(end - self._end, self._held.values.shape[1]))

    def forget(self, before: int) -> None:
        """Drop rows before a grid index."""
        self._needed = min(max(self._needed, before), self._end)
        self._parts = [part for part in self._parts if part.rows.stop > self._needed]

    def cut(self, rows: range) -> CutRows:
        """Return the rows of a window, none of them dropped before."""
        self.reach(rows.stop)
        held = self._held
        here = self._places(rows)
        parts = [self._part(part, rows) for part in self._parts]
        inside = [part for part in parts if len(part.rows)]
        return CutRows(
            values=held.values[here],
            lost=held.lost[here],
            filled=held.filled[here],
            bad=self._counted([part.bad for part in inside]) > 0,
            n_mended=self._counted([part.mended for part in inside]),
            summary=joined([part.summary for part in inside]),
        )

    def _part(self, part: _Part, rows: range) -> _Part:
        """Return what of a part lies in a window."""
        inside = range(max(part.rows.start, rows.start), min(part.rows.stop, rows.stop))
        if len(inside) in (0, len(part.rows)):
            return replace(part, rows=inside)
        first = inside.start - part.rows.start
        some = slice(first, first + len(inside))
        bad, mended = (None if each is None else each[some] for each in (part.bad, part.mended))
        return _Part(inside, self._summary(self._places(inside)), bad, mended)

    def _counted(self, masks: list[NDArray[np.bool_] | None]) -> NDArray[np.int64]:
        """Return how many rows of each channel are marked."""
        count = np.zeros(self._held.values.shape[1], dtype=np.int64)
        for mask in masks:
            if mask is not None:
                count += np.count_nonzero(mask, axis=0)
        return count

    def _summary(self, here: slice) -> Summary:
        return summarise(np.asarray(self._held.values[here], dtype=np.float64))

    def _places(self, rows: range) -> slice:
        return slice(rows.start - self._first, rows.stop - self._first)


def _arrays(rows: GridRows | _Held) -> tuple[NDArray[np.floating] | NDArray[np.bool_], ...]:
    return rows.values, rows.lost, rows.filled


def _room(n_rows: int, n_channels: int, dtype: 'np.dtype[np.floating]') -> _Held:
    return _Held(
        np.empty((n_rows, n_channels), dtype),
        np.empty(n_rows, dtype=bool),
        np.empty(n_rows, dtype=bool),
    )


def _is_looked_at(held: _Held) -> bool:
    """Tell whether there are views of the rows: every view refers to the array it is of."""
    return any(sys.getrefcount(array) > OWN_REFERENCES for array in _arrays(held))
