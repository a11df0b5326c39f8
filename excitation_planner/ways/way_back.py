"""The way back to where a plan starts, after a stop in the middle of it: one slow, short move.

A plan of its own, released like any other.  It is straight in axis angles and begins only where
the plan itself takes the arm: between the ranges of its axes, so that every pose on the way is one
of a range that a person has released.  An arm that stands elsewhere was moved since by others.
"""

import numpy as np
from numpy.typing import NDArray

from excitation_planner.bounds import PlanLimits
from excitation_planner.plan import ExcitationPlan
from excitation_planner.ways.approach import plan_approach
from modal_core.errors import PlanError

Array = NDArray[np.float64]
FARTHEST_RAD = np.deg2rad(3.0)
"""What is farther away is no way back but an approach, for which somebody looks at the room."""
SPEED_RAD_S = np.deg2rad(0.5)
"""Of the fastest axis: who lets go (0.5 s to standstill) stops it within a quarter of a degree."""
OTHER_WAYS = 'jog to the start pose, or plan the way: ama plan --approach-from'
BESIDE_RAD = np.deg2rad(0.2)
"""How far beside the ranges of a plan its stop, start tolerance and drives may leave it."""
THERE_RAD = np.deg2rad(0.1)
"""Half of what a bridge allows at the start of a plan."""


def is_there(here: Array, plan: ExcitationPlan) -> bool:
    """Tell whether serial joints (n_joints,) [rad] are where a plan starts."""
    return bool(np.max(np.abs(here - plan.start_position)) <= THERE_RAD)


def plan_way_back(here: Array, plan: ExcitationPlan, limits: PlanLimits) -> ExcitationPlan:
    """Plan the move to the start of a plan and seal it.

    Parameters
    ----------
    here : (n_joints,) array [rad]
        Serial joints, where the arm stands.
    plan : ExcitationPlan
        Whose start it goes back to.
    limits : PlanLimits
        What the move must keep.

    Raises
    ------
    PlanError
        The arm stands too far away, or where the plan does not take it; it is there already; or
        the move breaks a limit.
    """
    model = limits.model
    axes, planned = model.to_controller(here), model.to_controller(plan.position)
    _check_near(axes - planned[0], model.axis_names)
    low, high = planned.min(axis=0) - BESIDE_RAD, planned.max(axis=0) + BESIDE_RAD
    outside = (axes < low) | (axes > high)
    if outside.any():
        axis = int(np.argmax(outside))
        raise PlanError(
            f'{model.axis_names[axis]} stands where the plan does not take it: it was moved since',
            where='way back',
            found=f'{np.rad2deg(axes[axis]):.2f} deg',
            expected=f'{np.rad2deg(low[axis]):.2f} to {np.rad2deg(high[axis]):.2f} deg',
            advice=OTHER_WAYS,
        )
    return plan_approach(here, plan.start_position, limits, plan.sample_period_s, SPEED_RAD_S)


def _check_near(away: Array, names: tuple[str, ...]) -> None:
    axis = int(np.argmax(np.abs(away)))
    if np.abs(away[axis]) > FARTHEST_RAD:
        raise PlanError(
            f'{names[axis]} stands too far from the start of the plan',
            where='way back',
            found=f'{np.rad2deg(away[axis]):.2f} deg',
            expected=f'within {np.rad2deg(FARTHEST_RAD):g} deg',
            advice=OTHER_WAYS,
        )
