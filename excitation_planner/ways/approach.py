"""A plan that brings the arm to where an excitation starts: one slow move, released as any other.

A straight line in axis angles, all axes together.  Every limit of a plan holds for it, and self
collision is looked at; of the room it knows no more than the box it was given.
"""

import math

import numpy as np
from numpy.typing import NDArray

from excitation_planner.bounds import check_limits, Envelope, PlanLimits, REDUCED_SPEED_M_S
from excitation_planner.motion import (
    LEAST_ACCELERATION,
    LEAST_JERK,
    Pulse,
    pulse_velocity,
    PulseShape,
    quickest_shape,
    Trajectory,
)
from excitation_planner.plan import ExcitationPlan, rounded, sealed
from excitation_planner.signals import APPROACH
from modal_core.errors import PlanError
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]
# Part of the speed a plan may use, of every point of the arm and of every axis.
PART_OF_SPEED = 0.4
POSES_ON_THE_WAY = 200
SHORTEST_WAY_RAD = 1e-4


def plan_approach(
    start: Array,
    target: Array,
    limits: PlanLimits,
    sample_period_s: float,
    axis_speed: float = math.inf,
) -> ExcitationPlan:
    """Plan the move from one pose to another and seal it.

    Parameters
    ----------
    start, target : (n_joints,) array [rad]
        Serial joints.
    limits : PlanLimits
        What it must keep.
    sample_period_s : float [s]
        Of the trajectory.
    axis_speed : float [rad/s]
        No axis is faster.

    Raises
    ------
    PlanError
        It is there already, or the move breaks a limit.
    """
    way = target - start
    if np.max(np.abs(way)) < SHORTEST_WAY_RAD:
        raise PlanError('the arm is there already', where='approach_from')
    shape = _slow_shape(start, way, limits, axis_speed)
    n_samples = math.ceil(shape.duration_s / sample_period_s) + 3
    pulse = Pulse(sample_period_s, way, shape)
    velocity = pulse_velocity((pulse,), n_samples, sample_period_s)
    trajectory = Trajectory.from_velocity(start, velocity, sample_period_s)
    return _sealed_plan(trajectory, limits.model, check_limits(trajectory, limits), shape)


def _slow_shape(start: Array, way: Array, limits: PlanLimits, axis_speed: float) -> PulseShape:
    """Return the time course: slow everywhere on the way, and as gentle as AccSet goes."""
    model, axis_limits = limits.model, limits.model.limits
    part = np.linspace(0.0, 1.0, POSES_ON_THE_WAY)[:, None]
    fastest = model.geometry.fastest_point(start + part * way, np.tile(way, (len(part), 1)))
    along = np.maximum(np.abs(model.to_controller(way)), 1e-12)
    point_m_s = min(limits.point_speed_m_s, REDUCED_SPEED_M_S)
    speed = min(
        point_m_s / max(float(np.max(fastest.speed_m_s)), 1e-12),
        float(np.min(axis_limits.velocity / along)),
    )
    return quickest_shape(
        min(PART_OF_SPEED * speed, axis_speed / float(np.max(along))),
        LEAST_ACCELERATION * float(np.min(axis_limits.acceleration / along)),
        LEAST_JERK * float(np.min(axis_limits.jerk / along)),
    )


def _sealed_plan(
    trajectory: Trajectory, model: FlexibleJointModel, envelope: Envelope, shape: PulseShape
) -> ExcitationPlan:
    way = np.abs(trajectory.position[-1] - trajectory.position[0])
    # Samples round off the corners of a pulse; who plays it does not.
    peak_acceleration = np.maximum(envelope.peak_acceleration, way * shape.peak_acceleration)
    none = np.zeros(0)
    return sealed(
        ExcitationPlan(
            seed=0,
            robot_name=model.robot_name,
            signal=APPROACH,
            joint_names=tuple(model.joint_names),
            start_position=trajectory.position[0].copy(),
            position_range=np.ptp(trajectory.position, axis=0),
            peak_velocity=rounded(envelope.peak_velocity),
            peak_acceleration=rounded(peak_acceleration),
            peak_point_speed=float(rounded(envelope.peak_point_speed_m_s)),
            duration_s=trajectory.duration_s,
            band_low_hz=0.0,
            band_high_hz=0.0,
            torque_projection_rank=0,
            mode_frequency_hz=none,
            mode_frequency_sensitivity=none,
            mode_signal_to_noise_db=none,
            sample_period_s=trajectory.sample_period_s,
            position=trajectory.position,
            velocity=trajectory.velocity,
        )
    )
