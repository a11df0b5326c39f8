"""A spring whose stiffness depends on how fast its joint turns."""

from collections.abc import Sequence

from model_gap.laws.law import JointContext, SpringLaw
from model_gap.laws.solve import speed_spring


class SpeedStiffnessLaw(SpringLaw):
    """k β |q'| (r + e), r the twist at rest; values β [s/rad] and the share of gravity in r."""

    torque = speed_spring

    @staticmethod
    def constants(values: Sequence[float], context: JointContext) -> Sequence[float]:
        """Return the change of stiffness per speed, the twist at rest and the give."""
        beta, share = values
        return context.stiffness * beta, share * context.static_twist, context.give
