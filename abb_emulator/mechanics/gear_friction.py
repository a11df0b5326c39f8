"""Coulomb friction in the drives, solved for together with the motion it leaves."""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dgesv

from abb_emulator.mechanics.gear_settings import GearSettings

Array = NDArray[np.float64]
MOST_ITERATIONS = 20
TOLERANCE = 1e-4


class GearFriction:
    """T tanh(y' / v) against the rate of the twist.

    Friction at small speed is so steep that a torque taken from the beginning of a step would
    shake the light axes; it is the one that fits the rate at the end.

    Parameters
    ----------
    settings : GearSettings
        T and v on controller axes.
    """

    def __init__(self, settings: GearSettings) -> None:
        self._most = np.array(settings.friction_nm)
        self._speed = settings.friction_speed_rad_s
        self._steep = self._most / self._speed
        self.active = bool(self._most.any())
        self._tolerance = (TOLERANCE * float(self._most.max())) ** 2
        self.torque = np.zeros_like(self._most)
        self._before = np.zeros_like(self._most)

    def solve(self, free: Array, response: Array) -> Array:
        """Return the torque held over a step (Newton, steps halved where they do not help).

        Parameters
        ----------
        free : (n_axes,) array [rad/s]
            Rates of the twists at the end of the step without friction.
        response : (n_axes, n_axes) array
            Change of those per unit torque; taken off.
        """
        guess = 2.0 * self.torque - self._before
        torque = np.minimum(np.maximum(guess, -self._most), self._most)
        self._before = self.torque
        step, last = np.zeros_like(torque), np.inf
        for _ in range(MOST_ITERATIONS):
            grip = np.tanh((free - response @ torque) / self._speed)
            error = torque - self._most * grip
            size = float(error @ error)
            if size < self._tolerance:
                break
            if size > last:
                step = 0.5 * step
                torque = torque + step
                continue
            last = size
            slope = (self._steep * (1.0 - grip * grip))[:, None] * response
            slope.flat[:: len(torque) + 1] += 1.0
            step = dgesv(slope, error, overwrite_a=1)[2]
            torque = torque - step
        self.torque = np.asarray(torque)
        return self.torque
