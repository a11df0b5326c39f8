"""Laws of the twist between motor and link: springs, play, hysteresis, encoders."""

from collections.abc import Container, Mapping
from dataclasses import dataclass, replace
import math
from typing import ClassVar

import numpy as np

from model_gap.trajectory.hysteresis import sliding
from model_gap.trajectory.term import Array, Term, Track, TWIST, Weight

LINK_ENCODERS = 'link encoders'


@dataclass(frozen=True)
class OfTwist(Term):
    """A law of the twist of one gear."""

    quantity: ClassVar[str] = TWIST

    def column(self, track: Track, values: Array) -> Array:
        """Return a series of thinned samples as a column of this gear."""
        return track.column(self.axis, values, len(track.motion.encoders))


@dataclass(frozen=True)
class JointStiffness(OfTwist):
    """The gear is a spring, softer or stiffer than the model's.

    Its weight is the compliance beyond that of the model's spring; what is told is the whole.
    """

    type: ClassVar[str] = 'joint_stiffness'
    equation: ClassVar[str] = 'twist = load / k'
    says: ClassVar[str] = 'the gear of {place} has a stiffness of {stiffness:.3g} N m/rad'
    experiment: ClassVar[str] = 'the same motion with a known mass far out, or push the arm'
    kept_in: ClassVar[str] = 'model'

    # How roughly the load itself is known, relative.
    load_sigma: float = 0.0
    # Of the model's spring [N m/rad].
    model_stiffness: float = math.inf

    def weights(self) -> tuple[Weight, ...]:
        """Return the further compliance.

        As much as there is is plausible; without a spring in the model gears of a million N m/rad
        are soft for large arms.
        """
        there = 1.0 / self.model_stiffness
        return (Weight('compliance', 'rad/(N m)', there if there > 0.0 else 1e-6),)

    def possible(self, weights: Array, known: Container[tuple[str, str]]) -> bool:
        """Return whether the whole compliance is one: no gear is stiffer than rigid."""
        return bool(self.compliance(weights) > 0.0)

    def compliance(self, weights: Array) -> float:
        """Return the whole compliance, the model's spring included [rad/(N m)]."""
        return float(weights[0]) + 1.0 / self.model_stiffness

    def columns(self, track: Track) -> Array:
        """Return the load of the gear."""
        return self.column(track, track.load_nm[:, self.joint])

    def numbers(self, weights: Array, covariance: Array) -> dict[str, tuple[float, float, str]]:
        """Return the stiffness of the whole gear; what the load is wrong by it is wrong by."""
        compliance = self.compliance(weights)
        sigma = math.sqrt(max(self.variance(weights, covariance), 0.0))
        return {'stiffness': (1.0 / compliance, sigma / compliance**2, 'N m/rad')}

    def variance(self, weights: Array, covariance: Array) -> float:
        """Return the variance of the whole compliance.

        That of the load in the model's spring is in the covariance, see :class:`LoadTolerance`.
        """
        there, whole = 1.0 / self.model_stiffness, self.compliance(weights)
        more = max(whole**2 - there**2, 0.0)
        return float(covariance[0, 0]) + self.load_sigma**2 * more

    def weights_of(self, numbers: Mapping[str, float]) -> Array:
        """Return the further compliance."""
        return np.array([1.0 / numbers['stiffness'] - 1.0 / self.model_stiffness])

    def sentence(self, numbers: Mapping[str, float]) -> str:
        """Return how stiff it is, and how far off the model that is."""
        said = super().sentence(numbers)
        change = numbers['stiffness'] / self.model_stiffness - 1.0
        if math.isinf(self.model_stiffness):
            return said
        word = 'softer' if change < 0.0 else 'stiffer'
        return f'{said}, {100.0 * abs(change):.2g} % {word} than the model says'


@dataclass(frozen=True)
class LoadTolerance(OfTwist):
    """How roughly a load is known: always free within its prior, never named.

    Where the load of a right spring is wrong by a share, the spring looks wrong by that share.
    """

    type: ClassVar[str] = 'tolerance'
    equation: ClassVar[str] = 'twist = s load / k'
    says: ClassVar[str] = 'the load of {place} within its tolerance'

    load_sigma: float = 0.0
    model_stiffness: float = math.inf

    def weights(self) -> tuple[Weight, ...]:
        """Return the share."""
        return (Weight('share', '1', self.load_sigma),)

    def columns(self, track: Track) -> Array:
        """Return the twist of the model's spring."""
        return self.column(track, track.load_nm[:, self.joint] / self.model_stiffness)


@dataclass(frozen=True)
class CubicStiffness(OfTwist):
    """The gear gets stiffer (or softer) as it is loaded."""

    type: ClassVar[str] = 'cubic_stiffness'
    equation: ClassVar[str] = 'twist = b load³'
    says: ClassVar[str] = 'the gear of {place} does not twist in proportion to its load'

    def weights(self) -> tuple[Weight, ...]:
        """Return the coefficient: as much as the spring at 3 kN m."""
        return (Weight('cubic_compliance', 'rad/(N m)³', 1e-13),)

    def columns(self, track: Track) -> Array:
        """Return the cube of the load."""
        return self.column(track, track.load_nm[:, self.joint] ** 3)


@dataclass(frozen=True)
class EncoderDelay(Term):
    """The encoders behind the gears tell of the motion later than those of the motors."""

    type: ClassVar[str] = 'sensor_delay'
    quantity: ClassVar[str] = TWIST
    equation: ClassVar[str] = 'y(t) = q(t - τ)'
    says: ClassVar[str] = 'the {place} lag the motor encoders by {delay:.3g} s'
    experiment: ClassVar[str] = 'the same way at half the speed: a delay halves its twist'

    def weights(self) -> tuple[Weight, ...]:
        """Return the delay."""
        return (Weight('delay', 's', 0.005),)

    # The delay it is linear about.
    about_s: float = 0.0

    def recentred(self, weights: Array) -> 'EncoderDelay':
        """Return it linear about the delay that was found."""
        return replace(self, about_s=float(weights[0]))

    def columns(self, track: Track) -> Array:
        """Return the speed, of all encoders at once or of one: the mean one over the delay."""
        speed = track.motion.speed_over(self.about_s)[:, list(track.motion.encoders)]
        if self.location == LINK_ENCODERS:
            return speed[..., np.newaxis]
        return track.column(self.axis, speed[:, self.axis], speed.shape[1])


@dataclass(frozen=True)
class Hysteresis(OfTwist):
    """Friction on the link side of the gear, or flanks that stay where they slid to."""

    type: ClassVar[str] = 'gear_hysteresis'
    equation: ClassVar[str] = 'twist = b z, dz/dq = 1/w, -1 <= z <= 1'
    says: ClassVar[str] = 'the gear of {place} lags by {half_width:.2g} rad in either direction'
    shape_name: ClassVar[str] = 'presliding_angle'
    shape_unit: ClassVar[str] = 'rad'
    shapes: ClassVar[tuple[float, ...]] = (3e-4, 1e-3, 3e-3)

    def weights(self) -> tuple[Weight, ...]:
        """Return half the width of the loop."""
        return (Weight('half_width', 'rad', 1e-4),)

    def columns(self, track: Track) -> Array:
        """Return the state of sliding."""
        state = sliding(track.motion.path_rad[:, self.joint], self.shape)[0]
        return self.column(track, track.motion.slow(state))


@dataclass(frozen=True)
class Backlash(OfTwist):
    """Play: the gear jumps when its load changes sign."""

    type: ClassVar[str] = 'backlash'
    equation: ClassVar[str] = 'twist = b tanh(load/τ_0)'
    says: ClassVar[str] = 'the gear of {place} has a play of ±{half_gap:.2g} rad'
    experiment: ClassVar[str] = 'a motion in which the load of that axis changes its sign'
    shape_name: ClassVar[str] = 'transition_load'
    shape_unit: ClassVar[str] = 'N m'
    shapes: ClassVar[tuple[float, ...]] = (30.0, 100.0, 300.0)

    def weights(self) -> tuple[Weight, ...]:
        """Return half the play."""
        return (Weight('half_gap', 'rad', 1e-4),)

    def columns(self, track: Track) -> Array:
        """Return the sign of the load."""
        return self.column(track, np.tanh(track.load_nm[:, self.joint] / self.shape))


@dataclass(frozen=True)
class TransmissionError(OfTwist):
    """Gear or encoder is not round: an error that comes again with every part of a turn."""

    type: ClassVar[str] = 'transmission_error'
    equation: ClassVar[str] = 'twist = a sin(N q) + b (cos(N q) - 1)'
    says: ClassVar[str] = 'gear or encoder of {place} is not round, {order:.3g} periods a turn'
    experiment: ClassVar[str] = 'turn that axis slowly through its whole range'
    shape_name: ClassVar[str] = 'order'
    shape_unit: ClassVar[str] = '1'
    shapes: ClassVar[tuple[float, ...]] = (1.0, 2.0, 4.0, 8.0, 16.0, 32.0)

    def weights(self) -> tuple[Weight, ...]:
        """Return the two amplitudes."""
        return tuple(Weight(name, 'rad', 1e-4) for name in ('sine', 'cosine'))

    def columns(self, track: Track) -> Array:
        """Return sine and cosine of the joint's angle."""
        turn = self.shape * track.motion.joint_rad[:, track.motion.encoders[self.axis]]
        return self.column(track, np.column_stack([np.sin(turn), np.cos(turn)]))


@dataclass(frozen=True)
class EncoderOffset(OfTwist):
    """Where the encoder counts from: always free, a convention rather than a fault."""

    type: ClassVar[str] = 'encoder_offset'
    equation: ClassVar[str] = 'twist = b'
    says: ClassVar[str] = 'the link encoder of {place} counts from {offset:.3g} rad'

    def weights(self) -> tuple[Weight, ...]:
        """Return the offset."""
        return (Weight('offset', 'rad', 0.01),)

    def columns(self, track: Track) -> Array:
        """Return a constant."""
        return self.column(track, np.ones(track.motion.count))
