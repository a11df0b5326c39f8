"""What moves the commanded position of the axes from one controller cycle to the next."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class CommandedMotion(Protocol):
    """A source of commanded positions."""

    def step(self) -> Array:
        """Return the position at the end of the next cycle, (6,) [deg]."""

    @property
    def finished(self) -> bool:
        """The axes have come to rest where this motion takes them."""


class Stop:
    """Slow every axis down to standstill on a straight line in speed.

    Parameters
    ----------
    position_deg, speed_deg_s : (6,) array [deg], [deg/s]
        Where the axes are and how fast.
    stop_s : float [s]
        Time to standstill.
    cycle_s : float [s]
        Controller cycle.
    """

    def __init__(
        self, position_deg: Array, speed_deg_s: Array, stop_s: float, cycle_s: float
    ) -> None:
        self._position, self._speed = position_deg.copy(), speed_deg_s.copy()
        self._stop_s, self._cycle_s = max(stop_s, cycle_s), cycle_s
        self._time_s = 0.0

    @property
    def finished(self) -> bool:
        """The axes stand."""
        return self._time_s >= self._stop_s

    def step(self) -> Array:
        """Return the position at the end of the next cycle, (6,) [deg]."""
        self._time_s += self._cycle_s
        left = max(0.0, 1.0 - self._time_s / self._stop_s)
        self._position = self._position + left * self._speed * self._cycle_s
        return self._position
