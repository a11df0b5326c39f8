"""Laws of the drives' torques beside friction: counterbalance, payload, rotors.

All are linear in their weights; what they are not linear in is tried on a grid.
"""

from collections.abc import Container, Mapping
from dataclasses import dataclass, replace
import math
from typing import ClassVar

import numpy as np

from model_gap.trajectory.rigid import lower, NUMBERS, steiner
from model_gap.trajectory.term import Array, Term, Track, Weight


@dataclass(frozen=True)
class RotorInertia(Term):
    """The rotor of a motor is heavier or lighter than the model says."""

    type: ClassVar[str] = 'rotor_inertia'
    equation: ClassVar[str] = "τ = ΔJ N² q''"
    says: ClassVar[str] = "the rotor of {place} differs from the model's by {change:.3g} kg m²"
    kept_in: ClassVar[str] = 'model'

    ratio: float = 1.0
    nominal: float = 0.01

    def weights(self) -> tuple[Weight, ...]:
        """Return the change; as much as there is is plausible."""
        return (Weight('change', 'kg m²', self.nominal),)

    def columns(self, track: Track) -> Array:
        """Return the acceleration behind the gear."""
        motion = track.motion
        speed = motion.path_rate[:, self.joint]
        values = motion.slow(np.gradient(speed, 1.0 / motion.sample_rate_hz))
        return track.column(self.axis, self.ratio**2 * values, track.n_joints)


@dataclass(frozen=True)
class GravityCompensator(Term):
    """A counterbalance: spring, weight or gas cylinder between two links."""

    type: ClassVar[str] = 'gravity_compensator'
    carried: ClassVar[bool] = True
    equation: ClassVar[str] = 'τ = κ sin(q - φ)'
    says: ClassVar[str] = (
        '{place} has a counterbalance of {strength:.4g} N m, neutral at {phase:.3g} rad'
    )
    experiment: ClassVar[str] = 'stand still at five angles of that axis over its whole range'
    kept_in: ClassVar[str] = 'model'
    # It is built to be neutral where what it balances stands upright: to about 10 degrees.
    upright_rad: ClassVar[float] = 0.17

    size_nm: float = 1000.0
    upright: float = 0.0

    def weights(self) -> tuple[Weight, ...]:
        """Return what it does about the upright pose, and how far off that it is neutral."""
        return (
            Weight('along', 'N m', self.size_nm),
            Weight('across', 'N m', self.upright_rad * self.size_nm),
        )

    def columns(self, track: Track) -> Array:
        """Return sine and cosine of the angle from the upright pose."""
        turn = track.motion.joint_rad[:, self.joint] - self.upright
        values = np.column_stack([np.sin(turn), -np.cos(turn)])
        return track.column(self.axis, values, track.n_joints)

    def numbers(self, weights: Array, covariance: Array) -> dict[str, tuple[float, float, str]]:
        """Return strength and phase."""
        along, across = weights
        strength = math.copysign(math.hypot(along, across), along)
        slopes = np.array([[along, across], [-across, along]]) / np.array(
            [[abs(strength)], [strength**2]]
        )
        spread = np.sqrt(np.maximum(np.diag(slopes @ covariance @ slopes.T), 0.0))
        phase = self.upright + math.atan(across / along)
        return {
            'strength': (strength, float(spread[0]), 'N m'),
            'phase': (phase, float(spread[1]), 'rad'),
        }

    def weights_of(self, numbers: Mapping[str, float]) -> Array:
        """Return the weights of strength and phase."""
        turn = numbers['phase'] - self.upright
        return numbers['strength'] * np.array([math.cos(turn), math.sin(turn)])


@dataclass(frozen=True)
class Payload(Term):
    """A mass at the last link that the model does not have."""

    type: ClassVar[str] = 'payload'
    carried: ClassVar[bool] = True
    equation: ClassVar[str] = 'mass m at c of the last link'
    says: ClassVar[str] = '{place} carries {mass:+.3g} kg that the model does not have'
    experiment: ClassVar[str] = 'the same motion with a known mass at the flange'
    kept_in: ClassVar[str] = 'model'

    mass_kg: float = 10.0
    reach_m: float = 0.15
    flange: tuple[Array, Array] = (np.eye(3), np.zeros(3))
    centre: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def recentred(self, weights: Array) -> 'Payload':
        """Return it linear about the centre of mass that was found."""
        if weights[0] <= 0.0:
            return self
        found = self.numbers(weights, np.zeros((5, 5)))
        # No farther at a time than plausible: a first guess may be wild.
        x, y, z = (
            float(np.clip(found[f'com_{axis}'][0], about - self.reach_m, about + self.reach_m))
            for axis, about in zip('xyz', self.centre, strict=True)
        )
        return replace(self, centre=(x, y, z))

    def possible(self, weights: Array, known: Container[tuple[str, str]]) -> bool:
        """Return whether there is a mass; about one upright axis none at its centre is seen."""
        return bool(weights[0] != 0.0)

    def weights(self) -> tuple[Weight, ...]:
        """Return mass, mass times place, and inertia about its centre, alike about all axes."""
        moment = self.mass_kg * self.reach_m
        return (
            Weight('mass', 'kg', self.mass_kg),
            *(Weight(f'moment_{axis}', 'kg m', moment) for axis in 'xyz'),
            Weight('inertia', 'kg m²', moment * self.reach_m),
        )

    def columns(self, track: Track) -> Array:
        """Return what the inertial numbers of the last body do."""
        return np.asarray(track.rigid.bodies[:, :, -1] @ self._about_joint())

    def _about_joint(self) -> Array:
        """Return the inertial numbers of the body per weight, to first order about ``centre``."""
        turn = self.flange[0]
        place = self.flange[1] + turn @ np.array(self.centre)
        numbers = np.zeros((NUMBERS, 5))
        numbers[0, 0] = 1.0
        numbers[1:4, 0] = place
        numbers[4:, 0] = steiner(place, place)
        for axis in range(3):
            numbers[1:4, 1 + axis] = turn[:, axis]
            numbers[4:, 1 + axis] = 2.0 * steiner(place, turn[:, axis])
        numbers[4:, 4] = lower(np.eye(3))
        return numbers

    def numbers(self, weights: Array, covariance: Array) -> dict[str, tuple[float, float, str]]:
        """Return mass and centre of mass in the last link's frame, and its inertia."""
        deviations = np.sqrt(np.maximum(np.diag(covariance), 0.0))
        mass = weights[0]
        found = {'mass': (float(mass), float(deviations[0]), 'kg')}
        for place, axis in enumerate('xyz', start=1):
            moved = weights[place] / mass
            slope = np.zeros(len(weights))
            slope[0], slope[place] = -moved / mass, 1.0 / mass
            sigma = math.sqrt(max(float(slope @ covariance @ slope), 0.0))
            found[f'com_{axis}'] = (float(self.centre[place - 1] + moved), sigma, 'm')
        found['inertia'] = (float(weights[4]), float(deviations[4]), 'kg m²')
        return found

    def weights_of(self, numbers: Mapping[str, float]) -> Array:
        """Return the weights of mass and centre of mass."""
        place = [
            numbers['mass'] * (numbers[f'com_{axis}'] - about)
            for axis, about in zip('xyz', self.centre, strict=True)
        ]
        return np.array([numbers['mass'], *place, numbers['inertia']])
