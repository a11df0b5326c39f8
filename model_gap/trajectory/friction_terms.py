"""Laws of what resists an axis: friction of several kinds, and a hose's spring.

All are linear in their weights; what they are not linear in is tried on a grid.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from model_gap.trajectory.hysteresis import sliding
from model_gap.trajectory.term import Array, Term, Track, Weight

WHOLE_JOINT = 'whole joint'


@dataclass(frozen=True)
class OfFriction(Term):
    """What resists an axis: scaled by the torque the axis needs."""

    variant: ClassVar[str] = WHOLE_JOINT

    size_nm: float = 100.0

    def speed(self, track: Track) -> Array:
        """Return the axis' speed at the recording's rate [rad/s]."""
        return track.motion.path_rate[:, self.joint]

    def slow(self, track: Track, values: Array) -> Array:
        """Return a series as a column of this axis."""
        return track.column(self.axis, track.motion.slow(values), track.n_joints)


@dataclass(frozen=True)
class CoulombFriction(OfFriction):
    """Dry friction that gives way a little before it slides."""

    type: ClassVar[str] = 'coulomb_friction'
    one_way: ClassVar[bool] = True
    equation: ClassVar[str] = 'τ = τ_c z, dz/dq = 1/w, -1 <= z <= 1'
    says: ClassVar[str] = '{place} has dry friction of {torque:.3g} N m'
    shape_name: ClassVar[str] = 'presliding_angle'
    shape_unit: ClassVar[str] = 'rad'
    shapes: ClassVar[tuple[float, ...]] = (3e-5, 1e-4, 3e-4, 1e-3, 3e-3)

    def weights(self) -> tuple[Weight, ...]:
        """Return the level."""
        return (Weight('torque', 'N m', self.size_nm),)

    def columns(self, track: Track) -> Array:
        """Return the state of sliding."""
        return self.slow(track, sliding(track.motion.path_rad[:, self.joint], self.shape)[0])


@dataclass(frozen=True)
class LoadFriction(OfFriction):
    """Friction in proportion to what the gear carries."""

    type: ClassVar[str] = 'load_friction'
    one_way: ClassVar[bool] = True
    equation: ClassVar[str] = 'τ = μ |load| tanh(v/v_0)'
    says: ClassVar[str] = '{place} loses {share:.2g} of its load to friction'
    experiment: ClassVar[str] = 'the same motion with a known mass at the flange'
    shape_name: ClassVar[str] = 'transition_speed'
    shape_unit: ClassVar[str] = 'rad/s'
    shapes: ClassVar[tuple[float, ...]] = (3e-3, 1e-2)

    def weights(self) -> tuple[Weight, ...]:
        """Return the share."""
        return (Weight('share', '1', 0.2),)

    def columns(self, track: Track) -> Array:
        """Return the load with the sign of motion."""
        sign = track.motion.slow(np.tanh(self.speed(track) / self.shape))
        values = sign * np.abs(track.load_nm[:, self.joint])
        return track.column(self.axis, values, track.n_joints)


@dataclass(frozen=True)
class ViscousFriction(OfFriction):
    """Friction in proportion to speed."""

    type: ClassVar[str] = 'viscous_friction'
    one_way: ClassVar[bool] = True
    equation: ClassVar[str] = 'τ = d v'
    says: ClassVar[str] = '{place} has viscous friction of {damping:.4g} N m s/rad'

    def weights(self) -> tuple[Weight, ...]:
        """Return the coefficient."""
        return (Weight('damping', 'N m s/rad', 5.0 * self.size_nm),)

    def columns(self, track: Track) -> Array:
        """Return the speed."""
        return self.slow(track, self.speed(track))


@dataclass(frozen=True)
class StribeckFriction(OfFriction):
    """Friction that is higher (or lower) while a film of grease builds up."""

    type: ClassVar[str] = 'stribeck_friction'
    equation: ClassVar[str] = 'τ = τ_s exp(-|v|/v_s) tanh(v/(0.1 v_s))'
    says: ClassVar[str] = '{place} changes its friction by {torque:.3g} N m at low speed'
    experiment: ClassVar[str] = 'slow steady turns at five speeds between 0.001 and 0.1 rad/s'
    shape_name: ClassVar[str] = 'stribeck_speed'
    shape_unit: ClassVar[str] = 'rad/s'
    shapes: ClassVar[tuple[float, ...]] = (0.01, 0.03, 0.1)

    def weights(self) -> tuple[Weight, ...]:
        """Return the level."""
        return (Weight('torque', 'N m', self.size_nm),)

    def columns(self, track: Track) -> Array:
        """Return the bump at low speed."""
        ratio = self.speed(track) / self.shape
        return self.slow(track, np.exp(-np.abs(ratio)) * np.tanh(10.0 * ratio))


@dataclass(frozen=True)
class AsymmetricFriction(OfFriction):
    """Friction that differs between the two directions: a constant torque beside it."""

    type: ClassVar[str] = 'asymmetric_friction'
    equation: ClassVar[str] = 'τ = τ_a'
    says: ClassVar[str] = '{place} turns harder one way than the other, by {torque:.3g} N m'

    def weights(self) -> tuple[Weight, ...]:
        """Return half the difference."""
        return (Weight('torque', 'N m', 0.5 * self.size_nm),)

    def columns(self, track: Track) -> Array:
        """Return a constant."""
        return track.column(self.axis, np.ones(track.motion.count), track.n_joints)


@dataclass(frozen=True)
class HoseSpring(OfFriction):
    """A hose or cable that pulls the axis back to where it was laid."""

    type: ClassVar[str] = 'hose_spring'
    equation: ClassVar[str] = 'τ = k (q - q_0)'
    says: ClassVar[str] = '{place} is pulled by a spring of {stiffness:.3g} N m/rad'
    experiment: ClassVar[str] = 'stand still at five angles of that axis, from both sides'

    def weights(self) -> tuple[Weight, ...]:
        """Return the stiffness; where it is neutral is part of the asymmetry."""
        return (Weight('stiffness', 'N m/rad', self.size_nm),)

    def columns(self, track: Track) -> Array:
        """Return the angle since the start pose."""
        return self.slow(track, track.motion.path_rad[:, self.joint])
