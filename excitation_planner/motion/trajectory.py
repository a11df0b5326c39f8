"""A sampled motion and what it is between its samples.

The velocity samples are joined by a cubic spline that starts and ends without acceleration; the
position is its integral.  Everyone who plays or checks a plan uses this one interpolation, so
acceleration is continuous and the limits hold between the samples as well as on them.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline, PPoly

Array = NDArray[np.float64]
# What two ways of integrating the same velocity may differ by, over a whole plan.
CONSISTENT_RAD = 1e-8
# Trajectories are rounded so that the last bits of a library do not reach the hash.
DECIMALS = 13


@dataclass(frozen=True, slots=True)
class MotionOnGrid:
    """A motion evaluated on a grid of times.

    Parameters
    ----------
    time_s : (n_times,) array [s]
        Grid.
    position, velocity, acceleration, jerk : (n_times, n_joints) array [rad, rad/s, rad/s², rad/s³]
        Serial joints.
    """

    time_s: Array
    position: Array
    velocity: Array
    acceleration: Array
    jerk: Array


@dataclass(frozen=True)
class Trajectory:
    """Joint motion on a uniform grid, at rest at both ends.

    Parameters
    ----------
    sample_period_s : float [s]
        Spacing of the rows.
    position : (n_samples, n_joints) array [rad]
        Serial joints.
    velocity : (n_samples, n_joints) array [rad/s]
        Derivative of the position; zero in the first and last row.
    """

    sample_period_s: float
    position: Array
    velocity: Array

    @classmethod
    def from_velocity(cls, start: Array, velocity: Array, sample_period_s: float) -> 'Trajectory':
        """Integrate velocity samples from a start pose.

        Parameters
        ----------
        start : (n_joints,) array [rad]
            First row of the position.
        velocity : (n_samples, n_joints) array [rad/s]
            Zero in the first and last row.
        sample_period_s : float [s]
            Spacing of the rows.
        """
        rounded = np.round(velocity, DECIMALS) + 0.0
        travelled = _spline(rounded, sample_period_s).antiderivative()(
            _times(len(rounded), sample_period_s)
        )
        return cls(sample_period_s, np.round(start + travelled, DECIMALS) + 0.0, rounded)

    @property
    def n_samples(self) -> int:
        """Number of rows."""
        return len(self.position)

    @property
    def duration_s(self) -> float:
        """Time from the first row to the last [s]."""
        return (self.n_samples - 1) * self.sample_period_s

    @cached_property
    def time_s(self) -> Array:
        """Times of the rows [s]."""
        return _times(self.n_samples, self.sample_period_s)

    @cached_property
    def velocity_spline(self) -> PPoly:
        """Velocity between the samples: piecewise cubic, twice continuously differentiable."""
        return _spline(self.velocity, self.sample_period_s)

    @cached_property
    def position_spline(self) -> PPoly:
        """Position between the samples: the integral of :attr:`velocity_spline`."""
        spline = self.velocity_spline.antiderivative()
        spline.c[-1] += self.position[0]
        return spline

    @cached_property
    def acceleration(self) -> Array:
        """Acceleration at the samples, (n_samples, n_joints) [rad/s²]."""
        return np.asarray(self.velocity_spline.derivative()(self.time_s))

    def at(self, time_s: Array) -> MotionOnGrid:
        """Evaluate the motion at any times within it.

        Parameters
        ----------
        time_s : (n_times,) array [s]
            From 0 to :attr:`duration_s`.
        """
        spline = self.velocity_spline
        return MotionOnGrid(
            time_s=time_s,
            position=np.asarray(self.position_spline(time_s)),
            velocity=np.asarray(spline(time_s)),
            acceleration=np.asarray(spline.derivative(1)(time_s)),
            jerk=np.asarray(spline.derivative(2)(time_s)),
        )

    def finer(self, times: int) -> MotionOnGrid:
        """Evaluate the motion on a grid that is ``times`` as fine as the samples'."""
        n_fine = (self.n_samples - 1) * times + 1
        return self.at(np.linspace(0.0, self.duration_s, n_fine))

    def pieces(self, times: int, rows: int) -> Iterator[MotionOnGrid]:
        """Yield the finer grid in stretches of ``rows`` samples that overlap by two samples."""
        step_s = self.sample_period_s / times
        for first in range(0, max(self.n_samples - 2, 1), rows):
            last = min(first + rows + 2, self.n_samples - 1)
            yield self.at(np.asarray(np.arange(first * times, last * times + 1) * step_s))

    def inconsistency_rad(self) -> float:
        """Return the largest difference between the position rows and the integrated velocity."""
        return float(np.max(np.abs(self.position_spline(self.time_s) - self.position)))


def _times(n_samples: int, sample_period_s: float) -> Array:
    return np.asarray(np.arange(n_samples) * sample_period_s)


def _spline(velocity: Array, sample_period_s: float) -> CubicSpline:
    return CubicSpline(_times(len(velocity), sample_period_s), velocity, axis=0, bc_type='clamped')
