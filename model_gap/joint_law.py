"""Torques between motor and link that a spring and a damper do not give, solved implicitly.

A law is asked for the torque N at the end of a time step when twist and rate would be e and v
without it and fall by ``give``·N and ``rate_give``·N with it.
"""

from abc import ABC, abstractmethod
from enum import Enum
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from model_gap.cubic_root import CubicRoot

Array = NDArray[np.float64]
# Of α y² and of √α y: beyond, the torque that is not linear stays as it is there.
MOST_SOFTENING = 0.6
MOST_HARDENING = 3.0
# Third of the give times what the spring stiffens by: beyond, no parabola follows its steps.
STEEPEST = 0.03
# Of the play: teeth under less static twist than this rest between the flanks, not on one.
CENTRED = 1e-3
# To the speed that friction leaves: the torque is then right to 0.5 %, mostly to rounding.
NEWTON_STEPS = 3


class Follow(Enum):
    """Which twist a law is evaluated on."""

    PREDICTED = 'predicted'
    PARTED = 'measured above a few hertz, predicted below'
    MEASURED = 'measured'


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
    period_s : float [s]
        From step to step.
    """

    # Whether the static twist enters.
    preloaded: ClassVar[bool] = False
    # Which twist it sees, and while its numbers are still far off.
    sees: ClassVar[Follow] = Follow.PREDICTED
    sees_first: ClassVar[Follow] = Follow.PREDICTED
    # Whether the torque is proportional to the stiffness.
    of_spring: ClassVar[bool] = False

    def __init__(
        self,
        values: Array,
        stiffness: Array,
        static_twist: Array,
        give: Array,
        rate_give: Array,
        period_s: float,
    ) -> None:
        self.values = values
        self.stiffness = stiffness
        self.static_twist = static_twist
        self.give = give
        self.rate_give = rate_give
        self.period_s = period_s
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

    def surplus(self) -> Array | None:
        """Return the mean torque over the step just made less the mean of its ends, (n,).

        None where the torque may be taken to run straight from end to end.
        """
        return None


def held(values: Array, low: Array | float, high: Array | float) -> Array:
    """Return values inside a range; ``np.clip`` costs several times as much on short arrays."""
    return np.asarray(np.minimum(np.maximum(values, low), high))


class FrictionLaw(JointLaw):
    """F = τ·tanh(w/v₀) of the sliding speed w = v - p F'/k, k the joint's stiffness.

    Coulomb friction with a viscous transition, behind a spring: before it slides it gives way.
    Values τ, v₀ and p.  In steps of h, F' is (3F - 4F₁ + F₂)/2h, F₁ and F₂ the torques before:
    the spring slows the sliding like a further share 3p/(2hk) of the torque.

    References
    ----------
    Implicit steps: Curtiss and Hirschfelder (1952), doi:10.1073/pnas.38.3.235.
    """

    def prepare(self) -> None:
        """Set how much the torque slows the sliding within a step."""
        self.level, self.width, compliance = self.values
        self.yielding = 0.5 * compliance / (self.period_s * self.stiffness)
        self.braking = (self.rate_give + 3.0 * self.yielding) * self.level
        self.before = np.zeros_like(self.level)  # the torque two steps ago
        self.inner_share = 1.0 / (1.0 + self.braking / self.width)
        self.step = (np.zeros_like(self.level),) * 4  # last speed and torque, new speed and torque

    def torque(self, twist: Array, rate: Array, motor_speed: Array) -> Array:
        """Return the torque."""
        return self._at(rate)

    def _at(self, speed: Array) -> Array:
        """Solve w + b τ tanh(w/v₀) = v for the sliding speed w that is left.

        tanh(x) is less than x and than one: the larger of both bounds is below the root, from
        where Newton's steps on the concave function climb to it.
        """
        last = self.step[3]
        speed = speed + self.yielding * (4.0 * last - self.before)
        self.before = last
        free = np.abs(speed)
        left = np.maximum(free - self.braking, free * self.inner_share)
        for _ in range(NEWTON_STEPS):
            grip = np.tanh(left / self.width)
            slope = 1.0 + self.braking / self.width * (1.0 - grip * grip)
            left = left + (free - left - self.braking * grip) / slope
        left = np.copysign(left, speed)
        torque = np.asarray(self.level * np.tanh(left / self.width))
        self.step = (*self.step[2:], left, torque)
        return torque

    def surplus(self) -> Array | None:
        """Average over a speed that runs straight: the sign turns between steps, not at one.

        References
        ----------
        Parker, Zavalishin and Le Bivic (2016), antiderivative antialiasing, DAFx-16, eq. 10.
        """
        before, last, now, torque = self.step
        change = now - before
        still = np.abs(change) < 1e-3 * self.width
        mean = (self._integral(now) - self._integral(before)) / np.where(still, 1.0, change)
        return np.asarray(np.where(still, 0.0, mean - 0.5 * (last + torque)))

    def _integral(self, speed: Array) -> Array:
        """Return τ v₀ ln cosh(v/v₀), up to a constant."""
        size = np.abs(speed) / self.width
        return np.asarray(self.level * self.width * (size + np.log1p(np.exp(-2.0 * size))))


class JointFrictionLaw(FrictionLaw):
    """The same on the whole joint speed: friction between two links."""

    def torque(self, twist: Array, rate: Array, motor_speed: Array) -> Array:
        """Return the torque."""
        return self._at(rate + motor_speed)


class Parabola:
    """The parabola through the last three torques, where a straight line says too little.

    A line takes (ω h)²/12 off what may be a large part of the stiffness.  Where a step hardly
    resolves the stiffened joint the parabola would run away: the line stays.
    """

    def __init__(self, like: Array) -> None:
        self.torques = self.bends = (np.zeros_like(like),) * 3

    def add(self, torque: Array, bend: Array) -> None:
        """Take the next torque, and how much of ``STEEPEST`` the spring is stiffened by."""
        self.torques = (*self.torques[1:], torque)
        self.bends = (*self.bends[1:], bend)

    def surplus(self) -> Array:
        """Return the mean over the last step less that of its ends."""
        before, last, torque = self.torques
        bend = np.maximum(np.maximum(*self.bends[:2]), self.bends[2])
        return np.asarray((last + last - before - torque) / (12.0 + 12.0 * bend * bend))


class CubicLaw(JointLaw):
    """k α ((r + e)³ - r³), r the twist at rest: k r (1 + α r²) is the preload.

    Values α [1/rad²] and the share of gravity that preloads the spring.
    """

    preloaded = True
    sees_first = Follow.MEASURED
    of_spring = True

    def prepare(self) -> None:
        """Find the twist at rest and set the range: a softening spring never turns round."""
        alpha, share = self.values
        reach = np.sqrt(MOST_SOFTENING / np.maximum(-alpha, 1e-30))
        self.largest = np.where(
            alpha < 0.0, reach, MOST_HARDENING / np.sqrt(np.abs(alpha) + 1e-30)
        )
        rest = held(CubicRoot(alpha)(share * self.static_twist), -self.largest, self.largest)
        self.rate = self.stiffness * alpha
        yielding = self.give * self.rate
        self.at_rest = rest * rest * rest
        self.offset = rest + yielding * self.at_rest
        self.solve, self.steep = CubicRoot(yielding), np.abs(yielding) / STEEPEST
        self.parabola = Parabola(rest)

    def torque(self, twist: Array, rate: Array, motor_speed: Array) -> Array:
        """Return the torque: with y = r + e, y + give k α y³ is what it would be without."""
        whole = held(self.solve(twist + self.offset), -self.largest, self.largest)
        square = whole * whole
        torque = np.asarray(self.rate * (square * whole - self.at_rest))
        self.parabola.add(torque, self.steep * square)
        return torque

    def surplus(self) -> Array | None:
        """Average over the parabola through the last three steps."""
        return self.parabola.surplus()


class BacklashLaw(JointLaw):
    """k·dz(e + e_r, b) less the linear spring; values b [rad] and the share of gravity preload."""

    preloaded = True
    sees = Follow.PARTED
    sees_first = Follow.PARTED
    of_spring = True

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
    """k β |q'| (r + e), r the twist at rest; values β [s/rad] and the share of gravity in r."""

    preloaded = True
    sees_first = Follow.MEASURED
    of_spring = True

    def prepare(self) -> None:
        """Set the change of stiffness per speed."""
        beta, share = self.values
        self.rate, self.rest = self.stiffness * beta, share * self.static_twist
        self.steep = self.give / STEEPEST
        self.parabola = Parabola(beta)

    def torque(self, twist: Array, rate: Array, motor_speed: Array) -> Array:
        """Return the torque: linear in the twist."""
        added = self.rate * np.abs(motor_speed)
        torque = np.asarray(added * (self.rest + twist) / np.maximum(1.0 + self.give * added, 0.2))
        self.parabola.add(torque, self.steep * np.abs(added))
        return torque

    def surplus(self) -> Array | None:
        """Average over the parabola through the last three steps."""
        return self.parabola.surplus()
