"""Torque of the drives in excess of their linear springs: play, hardening, slip, change."""

import numpy as np
from numpy.typing import NDArray

from abb_emulator.mechanics.gear_settings import GearSettings
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]


class GearSprings:
    """k [(1 + c) (w + α w³) - y] + k s z: w is the twist y beyond the play, z the slipping part.

    There are two of the last: one that slips with the twist, and the friction of the joint, which
    slips with the angle of the axis and the twist together.

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
        self._slip = SlippingSpring(
            np.array(settings.slip_share) * self.stiffness, np.array(settings.slip_limit_rad)
        )
        self._stick = SlippingSpring(
            np.array(settings.stick_share) * self.stiffness, np.array(settings.stick_limit_rad)
        )
        self._varies = bool(self._beta.any() or self._drift.any())
        self._bends = self._varies or bool(self._play.any() or self._alpha.any())
        self.active = self._slip.active or self._stick.active or self._bends

    def factor(self, speed: Array, time_s: Array) -> Array:
        """Return 1 + c, the factor on each spring, (n_samples, n_axes).

        Parameters
        ----------
        speed : (n_samples, n_axes) array [rad/s]
            Of the controller axes.
        time_s : (n_samples,) array [s]
            Since the arm was switched on.
        """
        if not self._varies:
            return np.ones((len(time_s), len(self.stiffness)))
        warmth = 1.0 - np.exp(-time_s[:, None] / self._drift_s)
        return np.asarray(1.0 + self._beta * np.abs(speed) + self._drift * warmth)

    def torque(self, twist: Array, factor: Array, angle: Array) -> tuple[Array, Array]:
        """Return the torques and their slopes over the twist, (n_axes,) each.

        Parameters
        ----------
        twist : (n_axes,) array [rad]
            Of the controller axes.
        factor : (n_axes,) array
            One row of :meth:`factor`.
        angle : (n_axes,) array [rad]
            Of the controller axes.
        """
        torque = slope = np.zeros(len(self.stiffness))
        if self._bends:
            wound = twist - np.minimum(np.maximum(twist, -self._play), self._play)
            square = self._alpha * wound * wound
            torque = self.stiffness * (factor * (1.0 + square) * wound - twist)
            engaged = (wound != 0.0) | self._tight
            slope = self.stiffness * (engaged * factor * (1.0 + 3.0 * square) - 1.0)
        for spring, place in ((self._slip, twist), (self._stick, twist + angle)):
            if spring.active:
                more, steep = spring.torque(place)
                torque, slope = torque + more, slope + steep
        return torque, slope

    def rest(self, twist: Array, angle: Array) -> None:
        """Let slipping springs be slack at a twist."""
        self._slip.rest(twist)
        self._stick.rest(twist + angle)

    def arrive(self, twist: Array, angle: Array) -> None:
        """Remember the twist at the end of a step."""
        self._slip.arrive(twist)
        self._stick.arrive(twist + angle)


class SlippingSpring:
    """k z with dz/dx = 1 - sign(x') z / z_max (Dahl).

    Parameters
    ----------
    stiffness : (n_axes,) array [N m/rad]
        k, 0 where there is none.
    limit : (n_axes,) array [rad]
        z_max.
    """

    def __init__(self, stiffness: Array, limit: Array) -> None:
        self._stiffness, self._limit = stiffness, limit
        self.active = bool(stiffness.any())
        self._wound = self._place = np.zeros(len(limit))

    def torque(self, place: Array) -> tuple[Array, Array]:
        """Return the torque at a place x, and its slope."""
        wound, steep = self._moved(place)
        return self._stiffness * wound, self._stiffness * steep

    def rest(self, place: Array) -> None:
        """Be slack at a place."""
        self._place, self._wound = place, np.zeros(len(self._limit))

    def arrive(self, place: Array) -> None:
        """Remember the place at the end of a step."""
        if self.active:
            self._wound = self._moved(place)[0]
            self._place = place

    def _moved(self, place: Array) -> tuple[Array, Array]:
        """Return z, solved exactly for a way that does not turn in a step, and its slope."""
        way = place - self._place
        sign = np.sign(way)
        end = sign * self._limit
        wound = end - (end - self._wound) * np.exp(-np.abs(way) / self._limit)
        wound = np.where(way == 0.0, self._wound, wound)
        return wound, 1.0 - sign * wound / self._limit
