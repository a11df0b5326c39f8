"""The moves in a plan: what lies between one rest and the next.

Read back from the trajectory, so that whatever is made from them is a function of the plan its
hash binds.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from excitation_planner.motion import fitted_shape, PulseShape
from excitation_planner.plan import ExcitationPlan
from excitation_planner.signals import MOVES
from modal_core.errors import PlanError
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]
# Largest misfit of a move's sampled speed, over its peak.
MOST_MISFIT = 0.02


@dataclass(frozen=True, slots=True)
class Move:
    """One point-to-point move and the pause behind it.

    Parameters
    ----------
    start_s, duration_s, pause_s : float [s]
        When it begins, how long it takes, how long the arm then rests.
    displacement, target : (n_joints,) array [rad]
        Controller axes.
    shape : PulseShape
        Time course, the same for all axes.
    unit_speed : (n_samples,) array [1/s]
        The plan's own samples of it, from ``start_s`` on.
    sample_period_s : float [s]
        Between them.
    """

    start_s: float
    duration_s: float
    pause_s: float
    displacement: Array
    target: Array
    shape: PulseShape
    unit_speed: Array
    sample_period_s: float


def moves_of(plan: ExcitationPlan, model: FlexibleJointModel) -> tuple[Move, ...]:
    """Return the moves of a plan that is made of moves.

    Raises
    ------
    PlanError
        The plan's signal has no rests, is not for this robot, or something in it is no move of
        all joints together that speeds up, perhaps cruises and slows down.
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
    if plan.signal not in MOVES or len(starts) == 0:
        raise PlanError(
            'has no point-to-point moves',
            where='signal',
            found=plan.signal,
            expected=' or '.join(MOVES),
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
    rows = plan.velocity[start : end + 1]
    way = plan.position[end] - plan.position[start]
    unit = rows @ way / max(float(way @ way), 1e-300)
    shape, misfit = fitted_shape(unit, period_s)
    aside = float(np.max(np.abs(rows - np.outer(unit, way)))) / float(np.max(np.abs(rows)))
    if max(misfit, aside) > MOST_MISFIT:
        raise PlanError(
            'no move of all joints together that speeds up, cruises and slows down once',
            where=f'{start * period_s:.3f} to {end * period_s:.3f} s',
            found=f'{100 * max(misfit, aside):.1f} % of its speed away from one',
            expected=f'<= {100 * MOST_MISFIT:g} %',
        )
    return Move(
        start_s=start * period_s,
        duration_s=(end - start) * period_s,
        pause_s=pause * period_s,
        displacement=model.to_controller(way),
        target=model.to_controller(plan.position[end]),
        shape=shape,
        unit_speed=unit,
        sample_period_s=period_s,
    )
