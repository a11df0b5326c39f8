"""The rate of a source by all its stamps: steps counted across gaps."""

import numpy as np
from numpy.typing import NDArray

from modal_core.measurements import NANOSECONDS_PER_SECOND
from oma_identifier.intake.thresholds import INTAKE


class StepCount:
    """Counts steps between stamps; a gap counts as the steps that fit into it."""

    def __init__(self) -> None:
        self._first_ns = self._last_ns = self._n_steps = 0
        self._is_empty = True

    def add(self, stamps: NDArray[np.int64], period_ns: float) -> None:
        """Count the steps to stamps that are later than those before.

        Parameters
        ----------
        stamps : (n_samples,) int array [ns]
            In order.
        period_ns : float [ns]
            A step, roughly.
        """
        if self._is_empty and len(stamps):
            self._first_ns = self._last_ns = int(stamps[0])
            self._is_empty = False
        later = stamps[stamps > self._last_ns]
        if len(later):
            steps = np.rint(np.diff(later, prepend=self._last_ns) / period_ns)
            self._last_ns, self._n_steps = int(later[-1]), self._n_steps + int(steps.sum())

    @property
    def rate_hz(self) -> float | None:
        """Steps per second; None of too few."""
        if self._n_steps < INTAKE.fewest_for_rate:
            return None
        return self._n_steps * NANOSECONDS_PER_SECOND / (self._last_ns - self._first_ns)
