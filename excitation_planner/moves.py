"""The moves in a plan: what lies between one rest and the next.

Read back from the trajectory, so that whatever is made from them is a function of the plan its
hash binds.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from excitation_planner.plan import ExcitationPlan, RANDOM_PULSES
from modal_core.errors import PlanError
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Move:
    """One point-to-point move and the pause behind it.

    Parameters
    ----------
    start_s, duration_s, pause_s : float [s]
        When it begins, how long it takes, how long the arm then rests.
    target : (n_joints,) array [rad]
        Controller axes.
    acceleration_fraction, jerk_fraction : float
        Largest use of any axis' limit.
    tool_speed_m_s, tool_turning_rad_s : float [m/s], [rad/s]
        Peaks of the last link's frame.
    """

    start_s: float
    duration_s: float
    pause_s: float
    target: Array
    acceleration_fraction: float
    jerk_fraction: float
    tool_speed_m_s: float
    tool_turning_rad_s: float


def moves_of(plan: ExcitationPlan, model: FlexibleJointModel) -> tuple[Move, ...]:
    """Return the moves of a plan of random pulses.

    Raises
    ------
    PlanError
        The plan's signal has no rests, or is not for this robot.
    """
    if plan.joint_names != tuple(model.joint_names):
        raise PlanError(
            'the plan is for another robot',
            where='joint_names',
            found=', '.join(plan.joint_names),
            expected=', '.join(model.joint_names),
        )
    moving = np.any(plan.velocity != 0.0, axis=1).astype(int)
    starts = np.flatnonzero(np.diff(moving) == 1)
    ends = np.flatnonzero(np.diff(moving) == -1) + 1
    if plan.signal != RANDOM_PULSES or len(starts) == 0:
        raise PlanError(
            'has no point-to-point moves',
            where='signal',
            found=plan.signal,
            expected=RANDOM_PULSES,
        )
    pauses = np.append(starts[1:], plan.n_samples - 1) - ends
    return tuple(
        _move(plan, model, int(start), int(end), int(pause))
        for start, end, pause in zip(starts, ends, pauses, strict=True)
    )


def _move(
    plan: ExcitationPlan, model: FlexibleJointModel, start: int, end: int, pause: int
) -> Move:
    period_s = plan.sample_period_s
    inside = plan.trajectory.at(plan.trajectory.time_s[start : end + 1])
    acceleration = np.abs(model.to_controller(inside.acceleration))
    jerk = np.abs(model.to_controller(inside.jerk))
    motion = model.kinematics.motion(inside.position, inside.velocity)
    return Move(
        start_s=start * period_s,
        duration_s=(end - start) * period_s,
        pause_s=pause * period_s,
        target=model.to_controller(plan.position[end]),
        acceleration_fraction=float(np.max(acceleration / model.limits.acceleration)),
        jerk_fraction=float(np.max(jerk / model.limits.jerk)),
        tool_speed_m_s=float(np.max(np.linalg.norm(motion.velocity[:, -1], axis=1))),
        tool_turning_rad_s=float(np.max(np.linalg.norm(motion.spin[:, -1], axis=1))),
    )
