"""One move of constant acceleration and deceleration, with limited or unlimited jerk."""

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class PulseShape:
    """One move of unit length: accelerate, perhaps cruise, decelerate.

    Parameters
    ----------
    duration_s : float [s]
        Of the whole move.
    acceleration_s : float [s]
        Of the accelerating part, at most half the move; the decelerating part mirrors it.
    ramp_s : float [s]
        In which the acceleration rises to its plateau, at most half ``acceleration_s``; 0 gives
        the paper's rectangular pulses.
    """

    duration_s: float
    acceleration_s: float
    ramp_s: float = 0.0

    @property
    def peak_velocity(self) -> float:
        """Largest velocity of the unit move [1/s]."""
        return 1.0 / (self.duration_s - self.acceleration_s)

    @property
    def peak_acceleration(self) -> float:
        """Largest acceleration of the unit move [1/s²]."""
        return self.peak_velocity / (self.acceleration_s - self.ramp_s)

    @property
    def peak_jerk(self) -> float:
        """Largest jerk of the unit move [1/s³]; infinite for rectangular pulses."""
        return self.peak_acceleration / self.ramp_s if self.ramp_s > 0.0 else math.inf

    def velocity(self, time_s: Array) -> Array:
        """Return the velocity of the unit move, zero before and after it [1/s]."""
        rise = self._rise(time_s) - self._rise(time_s - (self.duration_s - self.acceleration_s))
        inside = (time_s > 0.0) & (time_s < self.duration_s)
        return np.where(inside, self.peak_acceleration * rise, 0.0)

    def spectrum(self, frequency_hz: Array) -> Array:
        """Return the magnitude of the Fourier transform of the acceleration [1/s].

        The acceleration is a rectangle of ``acceleration_s - ramp_s`` smoothed by one of
        ``ramp_s``, minus itself ``duration_s - acceleration_s`` later: a product of two sinc and
        one sine.
        """
        plateau_s = self.acceleration_s - self.ramp_s
        delay_s = self.duration_s - self.acceleration_s
        box = np.sinc(frequency_hz * plateau_s) * np.sinc(frequency_hz * self.ramp_s)
        pair = 2.0 * np.sin(np.pi * frequency_hz * delay_s)
        return np.asarray(np.abs(self.peak_velocity * box * pair))

    def _rise(self, time_s: Array) -> Array:
        """Integrate one accelerating part of unit plateau."""
        plateau_s = self.acceleration_s - self.ramp_s
        if self.ramp_s == 0.0:
            return np.clip(time_s, 0.0, plateau_s)
        corners = np.array([0.0, self.ramp_s, plateau_s, self.acceleration_s])
        signs = np.array([1.0, -1.0, -1.0, 1.0]) / (2.0 * self.ramp_s)
        since = np.clip(time_s[:, None] - corners, 0.0, None)
        return np.asarray(since**2 @ signs)
