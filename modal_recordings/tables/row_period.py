"""The period of rows from their times, however coarse the times are and whatever is missing."""

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

    The first and the last time may be those of a part of their rows: what lies between two
    changes is counted, gaps left out.

    Parameters
    ----------
    time_s : (n,) array [s]
        Time of each row; where it falls back, it begins anew.

    Returns
    -------
    float [s]
        Period; 0 where there is no whole time to count.
    float [s]
        How far the changes spread about the times of evenly spaced rows; inf with gaps.
    """
    changes = np.flatnonzero(np.diff(time_s)) + 1
    rows, ticks_s = np.diff(changes), np.diff(time_s[changes])
    whole = ticks_s > 0.0
    if not whole.any():
        return 0.0, 0.0
    whole &= ticks_s <= GAP_STEPS * np.median(ticks_s[whole])
    period_s = float(ticks_s[whole].sum() / rows[whole].sum())
    spread_s = float(np.ptp(time_s[changes] - period_s * changes)) if whole.all() else np.inf
    return period_s, spread_s
