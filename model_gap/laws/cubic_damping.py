"""A damper that grows with the cube of the speed."""

from collections.abc import Sequence

from model_gap.laws.law import JointContext, JointLaw
from model_gap.laws.solve import cubic_damper


class CubicDampingLaw(JointLaw):
    """N = c v³ of the twist's rate v; value c."""

    torque = cubic_damper

    @staticmethod
    def constants(values: Sequence[float], context: JointContext) -> Sequence[float]:
        """Return the coefficient and how the rate falls with the torque."""
        return values[0], context.rate_give
