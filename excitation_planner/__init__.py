"""How the robot should shake itself: range, direction, signal, limits, plan."""

from excitation_planner.limits import check_limits, Envelope, PlanLimits
from excitation_planner.plan import (
    APPROACH,
    BAND_LIMITED_NOISE,
    check_plan,
    ExcitationPlan,
    plan_hash,
    RANDOM_PULSES,
)
from excitation_planner.planner import plan_excitation, plan_limits
from excitation_planner.request import PlanRequest
from excitation_planner.trajectory import Trajectory

__all__ = [
    'APPROACH',
    'BAND_LIMITED_NOISE',
    'RANDOM_PULSES',
    'Envelope',
    'ExcitationPlan',
    'PlanLimits',
    'PlanRequest',
    'Trajectory',
    'check_limits',
    'check_plan',
    'plan_excitation',
    'plan_hash',
    'plan_limits',
]
