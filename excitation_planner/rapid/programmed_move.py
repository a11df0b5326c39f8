r"""What a program tells a controller of a move, such that the controller makes the planned one.

``MoveAbsJ`` goes on a straight line in axis angles, all axes together, as quickly as ``\T``
(speed), ``AccSet`` (acceleration and its build-up, in percent of the controller's own) and the
axes' limits allow.  AccSet below 20 % or 10 % is raised by the controller: a plan that is gentler
would be played harder than released, and is refused.

References
----------
ABB 3HAC050917-001, Technical reference manual, RAPID Instructions, Functions and Data types:
AccSet, MoveAbsJ.
"""

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from excitation_planner.motion import LEAST_ACCELERATION, LEAST_JERK, PulseShape, quickest_shape
from excitation_planner.plan import ExcitationPlan
from excitation_planner.rapid.moves import Move, moves_of
from modal_core.errors import PlanError
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]
# Speed of the move that is made beside the planned one's, over its peak, and peaks over the ones
# the plan states: what sampling and rounding may do.  Measured: no peak above the stated one in
# 30 random plans (test_rapid_release.py).
MOST_OFF = 0.03
# Differences in speed below this are rounding of what a program states.
TOLD_APART = 0.002
ADVICE = (
    'plan random_pulses anew, with joints that move together, acceleration_high of 0.2 or more,'
    ' build-up of acceleration, and a finer sample_period_s'
)


@dataclass(frozen=True, slots=True)
class ProgrammedMove:
    r"""One move as a program states it.

    Parameters
    ----------
    target : (n_joints,) array [rad]
        Controller axes.
    full_speed_s : float [s]
        How long the way takes at full speed, ``\T``.
    acceleration_percent, ramp_percent : float [%]
        AccSet.
    pause_s : float [s]
        Rest behind it.
    peak_speed, peak_acceleration : (n_joints,) array [rad/s], [rad/s²]
        Of the serial joints, as the controller makes it.
    """

    target: Array
    full_speed_s: float
    acceleration_percent: float
    ramp_percent: float
    pause_s: float
    peak_speed: Array
    peak_acceleration: Array


def programmed_moves(
    plan: ExcitationPlan, model: FlexibleJointModel
) -> tuple[ProgrammedMove, ...]:
    """Return how to program the moves of a plan.

    Raises
    ------
    PlanError
        The controller would make another motion of it, or a harder one than the plan states.
    """
    made = tuple(_programmed(move, model) for move in moves_of(plan, model))
    for name, found, stated in (
        ('speed', [move.peak_speed for move in made], plan.peak_velocity),
        ('acceleration', [move.peak_acceleration for move in made], plan.peak_acceleration),
    ):
        most = np.max(found, axis=0) / np.maximum(stated, 1e-12)
        joint = int(np.argmax(np.where(np.max(found, axis=0) > 1e-9, most, 0.0)))
        if most[joint] > 1.0 + MOST_OFF and np.max(found, axis=0)[joint] > 1e-9:
            raise PlanError(
                f'the controller would make more {name} of it than it states',
                where=plan.joint_names[joint],
                found=f'{most[joint]:.2f} times as much',
                expected=f'<= {1.0 + MOST_OFF:g}',
                advice=ADVICE,
            )
    return made


def _programmed(move: Move, model: FlexibleJointModel) -> ProgrammedMove:
    way = np.maximum(np.abs(move.displacement), 1e-12)
    acceleration, jerk = (
        float(np.min(limit / way)) for limit in (model.limits.acceleration, model.limits.jerk)
    )
    shape = move.shape
    # Rounded to the gentle side, as they are written.
    full_speed_s = math.ceil(1e4 / shape.peak_velocity) / 1e4
    percents = (
        _percent(shape.peak_acceleration / acceleration, LEAST_ACCELERATION),
        _percent(shape.peak_jerk / jerk, LEAST_JERK),
    )
    # Samples hardly tell ramps of a sample or two: of those that fit, the gentlest first.
    least = (100.0 * LEAST_ACCELERATION, 100.0 * LEAST_JERK)
    choices = [least, (percents[0], least[1]), (least[0], percents[1]), percents]
    made = [
        quickest_shape(1.0 / full_speed_s, percent / 100.0 * acceleration, ramp / 100.0 * jerk)
        for percent, ramp in choices
    ]
    off = [_away(move, shape) for shape in made]
    best = next((n for n, value in enumerate(off) if value < TOLD_APART), int(np.argmin(off)))
    if off[best] > MOST_OFF:
        raise _refusal(move, made[best], off[best])
    serial = np.abs(model.to_serial(move.displacement))
    return ProgrammedMove(
        target=move.target,
        full_speed_s=full_speed_s,
        acceleration_percent=choices[best][0],
        ramp_percent=choices[best][1],
        pause_s=move.pause_s,
        peak_speed=serial * made[best].peak_velocity,
        peak_acceleration=serial * made[best].peak_acceleration,
    )


def _percent(fraction: float, least: float) -> float:
    return min(max(math.floor(1e4 * fraction) / 1e2, 1e2 * least), 1e2)


def _away(move: Move, made: PulseShape) -> float:
    """Return the largest difference in speed from the planned move, over its peak."""
    n_samples = max(len(move.unit_speed), math.ceil(made.duration_s / move.sample_period_s) + 1)
    planned = np.zeros(n_samples)
    planned[: len(move.unit_speed)] = move.unit_speed
    time_s = np.asarray(np.arange(n_samples) * move.sample_period_s)
    return float(np.max(np.abs(made.velocity(time_s) - planned))) / float(np.max(planned))


def _refusal(move: Move, made: PulseShape, off: float) -> PlanError:
    harder = made.peak_acceleration / move.shape.peak_acceleration
    return PlanError(
        'the controller would make another move of it',
        where=f'move at {move.start_s:.3f} s',
        found=f'{100 * off:.0f} % of its speed away, {harder:.2f} times its acceleration',
        expected=f'<= {100 * MOST_OFF:g} %: AccSet goes from 20 and 10 to 100 %',
        advice=ADVICE,
    )
