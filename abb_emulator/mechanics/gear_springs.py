"""Torque of the drives in excess of their linear springs: play, hardening, slip, change."""

import numpy as np
from numpy.typing import NDArray

from abb_emulator.mechanics.gear_settings import GearSettings, N_AXES
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]


class GearSprings:
    """k [(1 + c) (w + α w³) - y] + k s z: w is the twist y beyond the play, z the slipping part.

    Parameters
    ----------
    settings : GearSettings
        Figures on controller axes.
    model : FlexibleJointModel
        Gives the stiffness k of each drive.

    References
    ----------
    Tunc and Gonul (2021), doi:10.1016/j.cirp.2021.04.006 (speed); Dahl (1976),
    doi:10.2514/3.61511 (slip).
    """

    def __init__(self, settings: GearSettings, model: FlexibleJointModel) -> None:
        stiffness = np.array([joint.drive.spring.stiffness for joint in model.spec.joints])
        self.stiffness = np.where(np.isfinite(stiffness), stiffness, 0.0)
        self._play = np.array(settings.backlash_rad)
        self._tight = self._play == 0.0
        self._alpha = np.array(settings.hardening_1_rad2)
        self._beta = np.array(settings.speed_stiffness_s_rad)
        self._drift = np.array(settings.drift_change)
        self._drift_s = np.array(settings.drift_time_s)
        share = np.array(settings.slip_share)
        self._slip_stiffness = share * self.stiffness
        self._limit = np.array(settings.slip_limit_rad)
        self._slips = bool(share.any())
        self._varies = bool(self._beta.any() or self._drift.any())
        self._bends = self._varies or bool(self._play.any() or self._alpha.any())
        self.active = self._slips or self._bends
        self._wound = self._twist = np.zeros(N_AXES)

    def factor(self, speed: Array, time_s: Array) -> Array:
        """Return 1 + c, the factor on each spring, (n_samples, 6).

        Parameters
        ----------
        speed : (n_samples, 6) array [rad/s]
            Of the controller axes.
        time_s : (n_samples,) array [s]
            Since the arm was switched on.
        """
        if not self._varies:
            return np.ones((len(time_s), N_AXES))
        warmth = 1.0 - np.exp(-time_s[:, None] / self._drift_s)
        return np.asarray(1.0 + self._beta * np.abs(speed) + self._drift * warmth)

    def torque(self, twist: Array, factor: Array) -> tuple[Array, Array]:
        """Return the torques and their slopes over the twist, (6,) each.

        Parameters
        ----------
        twist : (6,) array [rad]
            Of the controller axes.
        factor : (6,) array
            One row of :meth:`factor`.
        """
        torque = slope = np.zeros(N_AXES)
        if self._bends:
            wound = twist - np.minimum(np.maximum(twist, -self._play), self._play)
            square = self._alpha * wound * wound
            torque = self.stiffness * (factor * (1.0 + square) * wound - twist)
            engaged = (wound != 0.0) | self._tight
            slope = self.stiffness * (engaged * factor * (1.0 + 3.0 * square) - 1.0)
        if self._slips:
            wound, steep = self._slip(twist)
            torque = torque + self._slip_stiffness * wound
            slope = slope + self._slip_stiffness * steep
        return torque, slope

    def rest(self, twist: Array) -> None:
        """Let slipping springs be slack at a twist."""
        self._twist, self._wound = twist, np.zeros(N_AXES)

    def arrive(self, twist: Array) -> None:
        """Remember the twist at the end of a step."""
        if self._slips:
            self._wound = self._slip(twist)[0]
            self._twist = twist

    def _slip(self, twist: Array) -> tuple[Array, Array]:
        """Return how far the slipping springs are wound, and the slope of that over the twist.

        dz/dy = 1 - sign(y') z / z_max, solved exactly for a twist that goes one way in a step.
        """
        way = twist - self._twist
        sign = np.sign(way)
        end = sign * self._limit
        wound = end - (end - self._wound) * np.exp(-np.abs(way) / self._limit)
        wound = np.where(way == 0.0, self._wound, wound)
        return wound, 1.0 - sign * wound / self._limit
