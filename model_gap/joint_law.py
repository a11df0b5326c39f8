"""Torques between motor and link that a spring and a damper do not give, solved implicitly.

A law is asked for the torque N at the end of a time step when twist and rate would be e and v
without it and fall by ``give``·N and ``rate_give``·N with it.
"""

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
# Of α e²: beyond, the spring is held as it is there.
MOST_SOFTENING = 0.6
MOST_HARDENING = 30.0
# Of the play: teeth under less static twist than this rest between the flanks, not on one.
CENTRED = 1e-3


class JointLaw(ABC):
    """Torque of one joint in many records at once; one lane per record.

    Parameters
    ----------
    values : (n_parameters, n) array
        Parameters of every lane.
    stiffness : (n,) array [N m/rad]
        Of the joint's linear spring.
    static_twist : (n,) array [rad]
        Twist of the linear spring under gravity.
    give, rate_give : (n,) array
        Fall of twist and of its rate per unit of torque.
    """

    def __init__(
        self, values: Array, stiffness: Array, static_twist: Array, give: Array, rate_give: Array
    ) -> None:
        self.values = values
        self.stiffness = stiffness
        self.static_twist = static_twist
        self.give = give
        self.rate_give = rate_give
        self.prepare()

    @abstractmethod
    def prepare(self) -> None:
        """Work out what does not change from step to step."""

    @abstractmethod
    def torque(self, twist: Array, rate: Array, motor_speed: Array) -> Array:
        """Return N, the torque beyond that of the linear spring, (n,).

        Parameters
        ----------
        twist, rate : (n,) array [rad], [rad/s]
            Of the joint, without the torque asked for.
        motor_speed : (n,) array [rad/s]
            Of the joint.
        """


def held(values: Array, low: Array | float, high: Array | float) -> Array:
    """Return values inside a range; ``np.clip`` costs several times as much on short arrays."""
    return np.asarray(np.minimum(np.maximum(values, low), high))


class FrictionLaw(JointLaw):
    """τ·sat(v/v₀): Coulomb friction with a viscous transition; values τ, v₀."""

    def prepare(self) -> None:
        """Solve inside the transition, where the implicit equation is linear."""
        self.level, width = self.values
        self.slope = self.level / (width + self.rate_give * self.level)

    def torque(self, twist: Array, rate: Array, motor_speed: Array) -> Array:
        """Return the torque."""
        return held(self.slope * rate, -self.level, self.level)


class JointFrictionLaw(FrictionLaw):
    """The same on the whole joint speed: friction between two links."""

    def torque(self, twist: Array, rate: Array, motor_speed: Array) -> Array:
        """Return the torque."""
        return held(self.slope * (rate + motor_speed), -self.level, self.level)


class CubicLaw(JointLaw):
    """k α e³; value α [1/rad²]."""

    def prepare(self) -> None:
        """Set the range: a softening spring never turns round."""
        alpha = self.values[0]
        reach = np.sqrt(MOST_SOFTENING / np.maximum(-alpha, 1e-30))
        self.largest = np.where(
            alpha < 0.0, reach, MOST_HARDENING / np.sqrt(np.abs(alpha) + 1e-30)
        )
        self.rate = self.stiffness * alpha
        self.yielding = self.give * self.rate

    def torque(self, twist: Array, rate: Array, motor_speed: Array) -> Array:
        """Return the torque by Newton's method."""
        found = held(twist, -self.largest, self.largest)
        for _ in range(2):
            curve = self.yielding * found * found
            step = (found - twist + curve * found) / np.maximum(1.0 + 3.0 * curve, 0.2)
            found = held(found - step, -self.largest, self.largest)
        return np.asarray(self.rate * found * found * found)


class BacklashLaw(JointLaw):
    """k·dz(e + e_r, b) less the linear spring; values b [rad] and the share of gravity preload."""

    def prepare(self) -> None:
        """Solve between the flanks; on them the torque is constant."""
        gap, share = self.values
        k, rest = self.stiffness, share * self.static_twist
        self.load = k * rest
        place = rest + gap * held(rest / (CENTRED * gap), -1.0, 1.0)
        self.upper, self.lower = k * (place - gap) - self.load, k * (place + gap) - self.load
        self.slope = k / np.maximum(1.0 - self.give * k, 0.05)

    def torque(self, twist: Array, rate: Array, motor_speed: Array) -> Array:
        """Return the torque, continuous in the twist."""
        between = -self.load - self.slope * (twist + self.give * self.load)
        return held(between, self.upper, self.lower)


class SpeedStiffnessLaw(JointLaw):
    """k β |q'| e; value β [s/rad]."""

    def prepare(self) -> None:
        """Set the change of stiffness per speed."""
        self.rate = self.stiffness * self.values[0]

    def torque(self, twist: Array, rate: Array, motor_speed: Array) -> Array:
        """Return the torque: linear in the twist."""
        added = self.rate * np.abs(motor_speed)
        return np.asarray(added * twist / np.maximum(1.0 + self.give * added, 0.2))
