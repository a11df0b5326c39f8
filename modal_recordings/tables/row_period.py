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
