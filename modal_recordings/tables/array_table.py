"""Plain arrays from files, with what the file itself says about them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import RecordingError
from modal_recordings.disk import ReadPages, unreadable_npy

MOST_COLUMNS = 1024
ROWS_AT_ONCE = 1 << 12


@dataclass(frozen=True, slots=True)
class ArrayTable:
    """A table of samples as the file states it.

    Parameters
    ----------
    values : (n_samples, n_columns) array
        In the file's own units, times and counters among them; may be a memory map.
    headings : tuple of str
        One per column, as written; empty when the file does not say.
    units : tuple of str
        What a row of units says, one per column; empty when there is none.
    dated : tuple of int
        Columns that were written as dates or times of day, now in seconds.
    sample_rate_hz : float [Hz] or None
        Stated beside the table.
    calibrated : bool
        False: values over full scale, of which the unit must be told.
    notes : tuple of str
        What was left out.
    speed : int or None
        Column with the speed of a spindle.
    """

    values: NDArray[np.generic]
    headings: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    dated: tuple[int, ...] = ()
    sample_rate_hz: float | None = None
    calibrated: bool = True
    notes: tuple[str, ...] = ()
    speed: int | None = None

    def column(self, number: int) -> NDArray[np.float64]:
        """Return a copy of one column."""
        found, pages = np.empty(len(self.values)), ReadPages.behind(self.values)
        for first in range(0, len(found), ROWS_AT_ONCE):
            part = self.values[first : first + ROWS_AT_ONCE]
            found[first : first + len(part)] = part[:, number]
            pages.read(part.nbytes)
        return found

    def of_columns(self, chosen: Sequence[int]) -> 'ArrayTable':
        """Return the table of some columns alone, in that order."""
        kept = list(chosen)
        return replace(
            self,
            values=np.asarray(self.values)[:, kept],
            headings=tuple(self.headings[n] for n in kept) if self.headings else (),
            units=tuple(self.units[n] for n in kept) if self.units else (),
            dated=tuple(kept.index(n) for n in self.dated if n in kept),
            speed=kept.index(self.speed) if self.speed in kept else None,
        )


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
    return array_table(values, path)


def array_table(values: object, where: Path) -> ArrayTable:
    """Return an array as a table of samples by channels.

    Parameters
    ----------
    values : (n_samples, n_columns) or (n_samples,) array
        Real numbers.
    where : Path
        Named in errors.

    Raises
    ------
    RecordingError
        Not numbers, or not a table of samples by channels.
    """
    if not isinstance(values, np.ndarray) or values.dtype.kind not in 'fiu':
        raise RecordingError(
            'not real numbers',
            where=where,
            found=getattr(values, 'dtype', type(values).__name__),
            expected='floats or integers',
        )
    if values.ndim == 1:
        values = values[:, np.newaxis]
    if values.ndim == 2 and values.shape[1] > values.shape[0]:
        raise RecordingError(
            'more channels than samples',
            where=where,
            found=f'shape {values.shape}',
            expected='samples along the first axis',
            advice='transpose it',
        )
    if values.ndim != 2 or not 0 < values.shape[1] <= MOST_COLUMNS or len(values) < 2:
        raise RecordingError(
            'not a table',
            where=where,
            found=f'shape {values.shape}',
            expected=f'(samples, channels), at least 2 samples, at most {MOST_COLUMNS} channels',
        )
    return ArrayTable(values=values)
