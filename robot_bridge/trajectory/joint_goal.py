"""A plan as the points of a joint trajectory, close enough that its interpolation is the plan.

``joint_trajectory_controller`` goes from point to point on polynomials of degree five through
position, velocity and acceleration of both.  Between its own updates it commands nothing new.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from excitation_planner.motion import MotionOnGrid, Trajectory
from excitation_planner.plan import ExcitationPlan
from modal_core.errors import PlanError

Array = NDArray[np.float64]
STEP_S = 0.02
"""Wanted between points: a minute of six joints is then half a megabyte."""
TOLERANCE_RAD = 2e-6
"""Largest distance of the interpolation from the plan: a tenth of what a fine encoder tells."""
MOST_POINTS = 100_000
BAND_OF_RATE = 0.2
"""Part of the update rate that steps of it can carry: a held command loses 0.6 dB there
(sin(0.2 pi) / 0.2 pi), and its mirror image stands at four times that frequency."""


@dataclass(frozen=True, slots=True)
class JointGoal:
    """A trajectory as its controller takes it.

    Parameters
    ----------
    plan_hash : str
        Of the plan.
    joint_names : tuple of str
        One per column.
    time_s : (n_points,) array [s]
        From the beginning; the first is 0: where the robot must be by then, at rest.
    position, velocity, acceleration : (n_points, n_joints) array [rad, rad/s, rad/s²]
        At those times; at rest at both ends.
    """

    plan_hash: str
    joint_names: tuple[str, ...]
    time_s: Array
    position: Array
    velocity: Array
    acceleration: Array


def joint_goal(plan: ExcitationPlan) -> JointGoal:
    """Return the points of a plan, as few as its interpolation needs.

    Raises
    ------
    PlanError
        It takes too many points.
    """
    trajectory = plan.trajectory
    step = max(1, round(STEP_S / plan.sample_period_s))
    while step > 1 and _error_rad(trajectory, step) > TOLERANCE_RAD:
        step //= 2
    times = _times(trajectory, step)
    if len(times) > MOST_POINTS:
        raise PlanError(
            'takes too many points', where='plan', found=len(times), expected=f'<= {MOST_POINTS}'
        )
    motion = trajectory.at(times)
    return JointGoal(
        plan.plan_hash, tuple(plan.joint_names), times, motion.position,
        # At rest to the last digit: a controller refuses a trajectory that ends in motion.
        _resting(motion.velocity), _resting(motion.acceleration),
    )  # fmt: skip


def reach(plan: ExcitationPlan, update_rate_hz: float) -> str:
    """Say how much of a plan's band a controller of this rate can play."""
    highest_hz = BAND_OF_RATE * update_rate_hz
    begin = f'{update_rate_hz:.0f} Hz updates carry'
    if highest_hz >= plan.band_high_hz:
        return f'{begin} its band up to {plan.band_high_hz:.1f} Hz'
    if highest_hz <= plan.band_low_hz:
        return f'{begin} nothing above {highest_hz:.1f} Hz: not its band'
    return (
        f'{begin} {plan.band_low_hz:.1f} to {highest_hz:.1f} Hz of its band up to'
        f' {plan.band_high_hz:.1f} Hz, before what the drives take away'
    )


def _times(trajectory: Trajectory, step: int) -> Array:
    numbers = np.arange(0, trajectory.n_samples, step)
    if numbers[-1] != trajectory.n_samples - 1:
        numbers = np.append(numbers, trajectory.n_samples - 1)
    return np.asarray(numbers * trajectory.sample_period_s)


def _resting(values: Array) -> Array:
    values = values.copy()
    values[[0, -1]] = 0.0
    return values


def _error_rad(trajectory: Trajectory, step: int) -> float:
    """Return the largest distance of the interpolation from the plan at the plan's samples."""
    knots = _times(trajectory, step)
    ends = trajectory.at(knots)
    time_s = trajectory.time_s
    piece = np.clip(np.searchsorted(knots, time_s, 'right') - 1, 0, len(knots) - 2)
    found = _between(ends, knots, piece, time_s)
    return float(np.max(np.abs(found - trajectory.position)))


def _between(ends: MotionOnGrid, knots: Array, piece: NDArray[np.intp], time_s: Array) -> Array:
    """Return the positions on the polynomials of degree five between the ends of pieces."""
    length = (knots[piece + 1] - knots[piece])[:, None]
    part = (time_s - knots[piece])[:, None] / length
    p0, p1 = ends.position[piece], ends.position[piece + 1]
    v0, v1 = ends.velocity[piece] * length, ends.velocity[piece + 1] * length
    a0, a1 = (ends.acceleration[piece + k] * length**2 for k in (0, 1))
    way = p1 - p0
    third = 10.0 * way - 6.0 * v0 - 4.0 * v1 - 1.5 * a0 + 0.5 * a1
    fourth = -15.0 * way + 8.0 * v0 + 7.0 * v1 + 1.5 * a0 - a1
    fifth = 6.0 * way - 3.0 * (v0 + v1) - 0.5 * (a0 - a1)
    return np.asarray(
        p0 + part * (v0 + part * (0.5 * a0 + part * (third + part * (fourth + part * fifth))))
    )
