"""What no plan may exceed: in come a trajectory and a robot; out goes nothing, or a refusal.

Ranges, speeds, accelerations and the clearance of the arm from itself, over the whole length.
"""

from excitation_planner.bounds.limits import check_limits, Envelope, PlanLimits, REDUCED_SPEED_M_S

__all__ = [
    'REDUCED_SPEED_M_S',
    'Envelope',
    'PlanLimits',
    'check_limits',
]
