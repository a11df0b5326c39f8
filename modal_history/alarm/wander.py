"""Scatter of a natural frequency beyond its estimates: a part that wanders, a part that does not.

The wandering part is an Ornstein-Uhlenbeck process: correlated over hours, whatever it comes
from.  A Kalman filter turns residuals, and terms, into independent ones; results that repeat each
other then count for no more than they tell.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modal_core.work.compiled import compiled

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Wander:
    """Scatter of the logarithm of a frequency, beside the estimates' own deviations.

    Parameters
    ----------
    size : float
        Standard deviation of the part that wanders.
    memory_s : float [s]
        Its correlation time.
    white : float
        Standard deviation of the part that is new in every result.
    """

    size: float
    memory_s: float
    white: float

    def whitened(self, time_s: Array, variance: Array, columns: Array) -> tuple[Array, float]:
        """Return columns made independent with variance 1, and the log determinant.

        Parameters
        ----------
        time_s : (n,) array [s]
            Rising.
        variance : (n,) array
            Of the estimates.
        columns : (n, p) array
            What shares the scatter.
        """
        found = np.array(columns, dtype=float, order='C')
        log = _whiten(time_s, variance + self.white**2, found, self.size**2, self.memory_s)
        return found, log


@compiled
def _whiten(
    time_s: Array, variance: Array, columns: Array, squared: float, memory_s: float
) -> float:
    """Replace columns by their standardised innovations; return the sum of log variances."""
    n, p = columns.shape
    state, spread, log = np.zeros(p), squared, 0.0
    for row in range(n):
        if row:
            stays = np.exp(-(time_s[row] - time_s[row - 1]) / memory_s)
            spread = squared + stays * stays * (spread - squared)
            for column in range(p):
                state[column] *= stays
        total = spread + variance[row]
        gain, scale = spread / total, 1.0 / np.sqrt(total)
        log += np.log(total)
        for column in range(p):
            new = columns[row, column] - state[column]
            state[column] += gain * new
            columns[row, column] = new * scale
        spread *= 1.0 - gain
    return float(log)
