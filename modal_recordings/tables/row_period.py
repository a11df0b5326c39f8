"""The period of rows from their times, however coarse the times are and whatever is missing."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
DOUBLE_STEPS = 2.5
"""Times that are coarser than the rows have steps of one tick and of two; longer ones are gaps."""
GAP_STEPS = 1.5
"""A step longer than this many usual ones may be rows that are missing."""
MADE_UP_ROWS = 8
"""Rows within which the times of one that came late are those of the clock again."""


def row_period_s(time_s: Array) -> float:
    """Return the mean period of the rows' clock [s]; 0 where the usual step is none.

    A median or trimmed mean of the steps is that of the times' own resolution: of a period of
    1.95 ms in whole milliseconds it is 2 ms.  The slope of the times over the rows, from one
    gap to the next, is not.

    Parameters
    ----------
    time_s : (n,) array [s]
        Time of each row, n at least 2; where it falls back far, it begins anew.
    """
    steps = np.diff(time_s)
    ticks_s = float(np.median(steps))
    if ticks_s <= 0.0:
        return 0.0
    usual_s = float(np.mean(steps[np.abs(steps) <= DOUBLE_STEPS * ticks_s]))
    anew, kept = steps < -MADE_UP_ROWS * usual_s, np.ones(len(time_s), dtype=bool)
    for row in np.flatnonzero(steps > GAP_STEPS * usual_s):
        # One that came late is made up for by the next; the rows of a gap stay away.
        after = time_s[row + 1 : row + 1 + MADE_UP_ROWS]
        step_s = float(np.min(after - usual_s * np.arange(len(after)))) - float(time_s[row])
        anew[row] = step_s > GAP_STEPS * usual_s
        kept[row + 1] = anew[row]
    squares = products = 0.0
    begins = np.flatnonzero(anew) + 1
    for part, there in zip(np.split(time_s, begins), np.split(kept, begins), strict=True):
        place = np.flatnonzero(there).astype(float)
        place -= place.mean() if len(place) else 0.0
        squares += float(place @ place)
        products += float(place @ part[there])
    return products / squares if squares > 0.0 else usual_s


def shared_period_s(time_s: Array) -> tuple[float, float]:
    """Return the mean period of rows that share times, and by how much they leave it [s].

    The first and the last time before and after a pause may be those of a part of their rows: what
    lies between two changes is counted, pauses left out.

    Parameters
    ----------
    time_s : (n,) array [s]
        Time of each row; where it falls back, it begins anew.

    Returns
    -------
    float [s]
        Period; 0 where there is no whole time to count.
    float [s]
        How far the changes spread about the times of evenly spaced rows, from one pause to the
        next.
    """
    parts = [_changes(time_s, rows) for rows in unpaused(time_s)]
    ticks_s = sum(float(np.ptp(time_s[changes])) for changes in parts if len(changes))
    n_rows = sum(int(np.ptp(changes)) for changes in parts if len(changes))
    if not n_rows:
        return 0.0, 0.0
    period_s = ticks_s / n_rows
    spread_s = [np.ptp(time_s[each] - period_s * each) for each in parts if len(each)]
    return period_s, float(max(spread_s))


def unpaused(time_s: Array) -> list[slice]:
    """Return the rows from one pause, or beginning anew, to the next, of rows that share times."""
    steps = np.diff(time_s)
    if not (steps > 0.0).any():
        return [slice(0, len(time_s))]
    usual_s = GAP_STEPS * float(np.median(steps[steps > 0.0]))
    begins = np.flatnonzero((steps < 0.0) | (steps > usual_s)) + 1
    edges = [0, *begins.tolist(), len(time_s)]
    return [slice(first, last) for first, last in pairwise(edges)]


def evenly_shared_s(time_s: Array, period_s: float, parts: Sequence[slice]) -> Array:
    """Return times of evenly spaced rows; the first in a part that has a new time has it.

    Of a part in which none has, its first row does.  Parts are those of :func:`unpaused`.
    """
    even = np.empty(len(time_s))
    for rows in parts:
        first = int(_changes(time_s, rows)[:1].sum()) or rows.start
        even[rows] = time_s[first] + (np.arange(rows.start, rows.stop) - first) * period_s
    return even


def _changes(time_s: Array, rows: slice) -> NDArray[np.int64]:
    return np.asarray(np.flatnonzero(np.diff(time_s[rows])) + rows.start + 1)
