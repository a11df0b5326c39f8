"""Mean spectra in columns of time or of speed, in memory that does not grow."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
MOST_TIMES, MOST_SPEEDS = 600, 48
"""Columns of time, about as many as a chart has pixels, and of the speed of a joint."""
FIRST_SPEED_RAD_S = 1e-3
"""Width of a column of speed to begin with."""
FEWEST_COLUMNS = 8
"""That are joined no further."""
INSIDE = 1e-3
"""Of a column: what rounding may put before its begin belongs to it."""


class Columns:
    """Spectra by a value that is not negative.

    Columns begin at 0.  Where a value lies beyond the last one, neighbours become one, so that
    their width doubles.

    Parameters
    ----------
    width : float
        Of a column to begin with.
    most : int
        Columns, an even number.
    n_lines : int
        Of a spectrum.
    """

    def __init__(self, width: float, most: int, n_lines: int) -> None:
        self.width = width
        self._power = np.zeros((most, n_lines), dtype=np.float32)
        self._count = np.zeros(most)

    def add(self, value: float, psd: Array) -> None:
        """Put a spectrum into the column of its value."""
        while value >= len(self._count) * self.width:
            self._join_neighbours()
        at = min(int(value / self.width + INSIDE), len(self._count) - 1)
        self._power[at] += psd
        self._count[at] += 1.0

    def thin(self) -> None:
        """Join neighbours until a column has two spectra on average: gaps would hide a line."""
        while FEWEST_COLUMNS < len(self) > self._count.sum() / 2.0:
            self._join_neighbours()

    def _join_neighbours(self) -> None:
        half = len(self._count) // 2
        for array in (self._power, self._count):
            array[:half] = array[0::2] + array[1::2]
            array[half:] = 0.0
        self.width *= 2.0

    def __len__(self) -> int:
        """Return how many columns there are up to the last that has a spectrum."""
        held = np.flatnonzero(self._count)
        return int(held[-1]) + 1 if len(held) else 0

    @property
    def middle(self) -> Array:
        """Middles of the columns, (n_columns,)."""
        return np.asarray(self.width * (np.arange(len(self)) + 0.5), dtype=np.float64)

    @property
    def mean(self) -> Array:
        """Mean spectra, (n_columns, n_lines); NaN in columns without any."""
        count = self._count[: len(self)]
        held = np.where(count > 0.0, count, np.nan)
        return np.asarray(self._power[: len(self)] / held[:, None], dtype=float)
