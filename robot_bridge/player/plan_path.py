"""A plan as a path in controller angles that can be read at any time."""

from collections.abc import Callable
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from excitation_planner.motion import Trajectory
from modal_core.errors import PlanError

Array = NDArray[np.float64]
STILL_DEG = 1e-6


@dataclass(frozen=True, slots=True)
class PlanPath:
    """Piecewise polynomial path of the axes, the planner's own interpolation.

    Parameters
    ----------
    plan_hash : str
        Which plan this is.
    sample_period_s : float [s]
        Length of one piece.
    coefficients : (n_coefficients, n_pieces, 6) array [deg]
        Highest power of the time since the piece began first.
    """

    plan_hash: str
    sample_period_s: float
    coefficients: Array

    @property
    def duration_s(self) -> float:
        """Length of the path [s]."""
        return float(self.coefficients.shape[1] * self.sample_period_s)

    @property
    def start_deg(self) -> Array:
        """Where the path begins, (6,) [deg]."""
        return np.asarray(self.coefficients[-1, 0])

    @property
    def quickest_1_s(self) -> float:
        """Rate [1/s] at which the path's own speed runs through its reach, on its slowest axis.

        The smallest ratio, over the axes that move, of the largest speed at a sample to the
        largest distance from the start at one.
        """
        position, speed = self.coefficients[-1], self.coefficients[-2]
        reach = np.abs(position - position[0]).max(axis=0)
        moves = reach > STILL_DEG
        if not moves.any():
            return math.inf
        return float((np.abs(speed).max(axis=0)[moves] / reach[moves]).min())

    def position(self, time_s: float) -> Array:
        """Return the axis angles at a time, (6,) [deg]; the ends hold before and after."""
        time_s = min(max(time_s, 0.0), self.duration_s)
        piece = min(int(time_s / self.sample_period_s), self.coefficients.shape[1] - 1)
        local = time_s - piece * self.sample_period_s
        value = self.coefficients[0, piece]
        for coefficient in self.coefficients[1:, piece]:
            value = value * local + coefficient
        return np.asarray(value)

    @classmethod
    def from_trajectory(
        cls,
        plan_hash: str,
        trajectory: Trajectory,
        to_controller: Callable[[Array], Array],
    ) -> 'PlanPath':
        """Build the path of a planned trajectory.

        Parameters
        ----------
        plan_hash : str
            Which plan this is.
        trajectory : Trajectory
            Motion of the serial joints [rad].
        to_controller : callable
            Linear map of serial joint angles (6,) to controller axis angles (6,), both [rad].

        Raises
        ------
        PlanError
            Shapes do not fit, or a number is not finite.
        """
        position, velocity = trajectory.position, trajectory.velocity
        if position.ndim != 2 or position.shape != velocity.shape or len(position) < 2:
            raise PlanError('position and velocity differ', found=(position.shape, velocity.shape))
        if not (np.isfinite(position).all() and np.isfinite(velocity).all()):
            raise PlanError('not finite', where='position or velocity')
        n_joints = position.shape[1]
        offset = np.asarray(to_controller(np.zeros(n_joints)), float)
        linear = np.array([to_controller(row) for row in np.eye(n_joints)]) - offset
        coefficients = np.degrees(trajectory.position_spline.c @ linear)
        coefficients[-1] += np.degrees(offset)
        return cls(plan_hash, trajectory.sample_period_s, np.ascontiguousarray(coefficients))
