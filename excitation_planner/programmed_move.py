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

from excitation_planner.moves import Move
from excitation_planner.pulse_shape import PulseShape
from excitation_planner.quickest_shape import LEAST_ACCELERATION, LEAST_JERK, quickest_shape
from modal_core.errors import PlanError
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]
# Peak speed and acceleration of the move that is made, over the planned one's: what sampling and
# rounding may do.  Measured: within 1.4 % over 30 random plans (test_rapid_release.py).
MOST_OFF = 0.03


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
    """

    target: Array
    full_speed_s: float
    acceleration_percent: float
    ramp_percent: float
    pause_s: float


def programmed_move(move: Move, model: FlexibleJointModel) -> ProgrammedMove:
    """Return how to program a planned move.

    Raises
    ------
    PlanError
        The controller would make another move of it.
    """
    way = np.maximum(np.abs(move.displacement), 1e-12)
    acceleration, jerk = (
        float(np.min(limit / way)) for limit in (model.limits.acceleration, model.limits.jerk)
    )
    made = ProgrammedMove(
        target=move.target,
        # Rounded to the gentle side, as it is written.
        full_speed_s=math.ceil(1e4 / move.shape.peak_velocity) / 1e4,
        acceleration_percent=_percent(
            move.shape.peak_acceleration / acceleration, LEAST_ACCELERATION
        ),
        ramp_percent=_percent(move.shape.peak_jerk / jerk, LEAST_JERK),
        pause_s=move.pause_s,
    )
    _check_same(move, quickest_shape(
        1.0 / made.full_speed_s,
        made.acceleration_percent / 100.0 * acceleration,
        made.ramp_percent / 100.0 * jerk,
    ))  # fmt: skip
    return made


def _percent(fraction: float, least: float) -> float:
    return min(max(math.floor(1e4 * fraction) / 1e2, 1e2 * least), 1e2)


def _check_same(move: Move, made: PulseShape) -> None:
    """Refuse a move of which the controller makes another one."""
    planned = move.shape
    for name, found, wanted in (
        ('speed', made.peak_velocity, planned.peak_velocity),
        ('acceleration', made.peak_acceleration, planned.peak_acceleration),
    ):
        if abs(found / wanted - 1.0) > MOST_OFF:
            raise PlanError(
                f'the controller would make another move of it: {found / wanted:.2f} times'
                f' the planned {name}',
                where=f'move at {move.start_s:.3f} s',
                expected=f'within {100 * MOST_OFF:g} %: AccSet goes from 20 and 10 to 100 %',
                advice='plan random_pulses anew, with acceleration_high of 0.2 or more, build-up'
                ' of acceleration, and joints that move together',
            )
