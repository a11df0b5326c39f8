"""Torques between motor and link that a spring and a damper do not give, solved implicitly.

A law is asked for the torque N at the end of a time step when twist and rate would be e and v
without it and fall by ``give``·N and ``rate_give``·N with it.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
# Of α e²: beyond, the spring is held as it is there.
MOST_SOFTENING = 0.6
MOST_HARDENING = 30.0
# Of the play: teeth under less static twist than this rest between the flanks, not on one.
CENTRED = 1e-3


@dataclass(frozen=True)
class JointState:
    """Everything a law may depend on, one entry per lane.

    Parameters
    ----------
    twist, rate : (n,) array [rad], [rad/s]
        Of the joint, without the torque asked for.
    give, rate_give : (n,) array
        Fall of both per unit of torque.
    motor_speed : (n,) array [rad/s]
        Of the joint.
    """

    twist: Array
    rate: Array
    give: Array
    rate_give: Array
    motor_speed: Array


class JointLaw(ABC):
    """Torque of one joint in many records at once.

    Parameters
    ----------
    values : (n_parameters, n) array
        Parameters of every lane.
    stiffness : (n,) array [N m/rad]
        Of the joint's linear spring.
    static_twist : (n,) array [rad]
        Twist of the linear spring under gravity.
    """

    def __init__(self, values: Array, stiffness: Array, static_twist: Array) -> None:
        self.values = values
        self.stiffness = stiffness
        self.static_twist = static_twist

    @abstractmethod
    def torque(self, state: JointState) -> Array:
        """Return N, the torque beyond that of the linear spring."""


def held(values: Array, low: Array | float, high: Array | float) -> Array:
    """Return values inside a range; ``np.clip`` costs several times as much on short arrays."""
    return np.asarray(np.minimum(np.maximum(values, low), high))


class FrictionLaw(JointLaw):
    """τ·sat(v/v₀): Coulomb friction with a viscous transition; values τ, v₀."""

    def torque(self, state: JointState) -> Array:
        """Return the torque; inside the transition the implicit equation is linear."""
        level, width = self.values
        return np.asarray(level * held(state.rate / (width + state.rate_give * level), -1.0, 1.0))


class JointFrictionLaw(FrictionLaw):
    """The same on the whole joint speed: friction between two links."""

    def torque(self, state: JointState) -> Array:
        """Return the torque."""
        level, width = self.values
        speed = state.rate + state.motor_speed
        return np.asarray(level * held(speed / (width + state.rate_give * level), -1.0, 1.0))


class CubicLaw(JointLaw):
    """k α e³; value α [1/rad²]."""

    def torque(self, state: JointState) -> Array:
        """Return the torque by Newton's method; a softening spring never turns round."""
        alpha = self.values[0]
        reach = np.sqrt(MOST_SOFTENING / np.maximum(-alpha, 1e-30))
        largest = np.where(alpha < 0.0, reach, MOST_HARDENING / np.sqrt(np.abs(alpha) + 1e-30))
        rate = self.stiffness * alpha
        twist = held(state.twist, -largest, largest)
        for _ in range(2):
            wrong = twist + state.give * rate * twist**3 - state.twist
            slope = 1.0 + 3.0 * state.give * rate * twist**2
            twist = held(twist - wrong / np.maximum(slope, 0.2), -largest, largest)
        return np.asarray(rate * twist**3)


class BacklashLaw(JointLaw):
    """k·dz(e + e_r, b) less the linear spring; values b [rad] and the share of gravity preload."""

    def torque(self, state: JointState) -> Array:
        """Return the torque: linear in three branches."""
        gap, share = self.values
        k, rest = self.stiffness, share * self.static_twist
        load = k * rest
        place = rest + gap * held(rest / (CENTRED * gap), -1.0, 1.0)
        upper, lower = k * (place - gap) - load, k * (place + gap) - load
        high = state.twist - state.give * upper + place > gap
        low = state.twist - state.give * lower + place < -gap
        inside = (state.twist + state.give * load) / np.maximum(1.0 - state.give * k, 0.05)
        return np.asarray(np.where(high, upper, np.where(low, lower, -load - k * inside)))


class SpeedStiffnessLaw(JointLaw):
    """k β |q'| e; value β [s/rad]."""

    def torque(self, state: JointState) -> Array:
        """Return the torque: linear in the twist."""
        rate = self.stiffness * self.values[0] * np.abs(state.motor_speed)
        return np.asarray(rate * state.twist / np.maximum(1.0 + state.give * rate, 0.2))
