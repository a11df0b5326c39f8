"""Whether a column counts up, as times and counters do and vibration never does."""

import numpy as np
from numpy.typing import NDArray

from modal_recordings.disk import ReadPages

FEWEST_COUNTED = 50
"""Vibration that rose through so many rows would have half a period of their length or more: it
could not be identified from them.  Noise rises through 50 rows once in 50! = 3e64."""
LEAST_STEPS = 0.02
"""Share of rows that a coarse clock moves on, 50 samples to a stamp at most; a sensor that is
stuck but for a jump or two does not count."""
LARGEST_SCATTER = 2.0
"""About a straight line, in its steps; the slope of 50 rows of noise, of which it is one part in
two, is 50 deviations from zero."""
EVEN_SHARE = 0.9
"""Share of steps that are one and the same in a counter that wraps around."""
PIECE_ROWS = 1 << 12


def counts_up(column: NDArray[np.generic]) -> bool:
    """Tell whether a column never falls, or goes evenly but for where it begins anew.

    A time whose stamps jitter by more than a step falls, too, as does one that counts down.

    Parameters
    ----------
    column : (n_samples,) array
        May be a memory map; all of it is looked at only if its beginning counts up.
    """
    if len(column) < FEWEST_COUNTED:
        return False
    n_rises, pages = 0, ReadPages.behind(column)
    for first in range(0, len(column) - 1, PIECE_ROWS):
        part = np.asarray(column[first : first + PIECE_ROWS + 1], dtype=np.float64)
        pages.read(len(part) * abs(column.strides[0]))
        with np.errstate(invalid='ignore', over='ignore'):  # of infinite and of damaged values
            steps = np.diff(part)
        if not np.isfinite(steps).all() or (steps < 0.0).any():
            beginning = np.asarray(column[:PIECE_ROWS], dtype=np.float64)
            return bool(np.isfinite(beginning).all()) and (
                _is_even(beginning) or _is_line(beginning)
            )
        n_rises += int(np.count_nonzero(steps))
    return n_rises >= max(FEWEST_COUNTED / 2, LEAST_STEPS * len(column))


def _is_even(column: NDArray[np.float64]) -> bool:
    """Tell whether nearly every step is the same and upwards."""
    steps = np.diff(column)
    step = float(np.median(steps))
    # To the last digit of a double, or of the decimals that were printed.
    near = np.abs(steps - step) <= 1e-6 * abs(step) + 4.0 * np.spacing(np.abs(column[1:]))
    return step > 0.0 and bool(np.count_nonzero(near) >= EVEN_SHARE * len(steps))


def _is_line(column: NDArray[np.float64]) -> bool:
    """Tell whether a column runs along a straight line, up or down, nearer than vibration can."""
    largest = float(np.abs(column).max())
    if largest == 0.0:
        return False
    # In units of the largest: squares of damaged numbers may be beyond what a double holds.
    row = np.arange(len(column)) - 0.5 * (len(column) - 1)
    rest = column / largest
    rest -= rest.mean()
    slope = float(row @ rest / (row @ row))
    return slope != 0.0 and float(np.std(rest - slope * row)) < LARGEST_SCATTER * abs(slope)
