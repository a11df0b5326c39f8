"""Stops to either side of a joint's twist."""

from collections.abc import Sequence

from model_gap.laws.law import JointContext, JointLaw
from model_gap.laws.solve import stopped


class StopLaw(JointLaw):
    """N = r k d (1 + l d'), d = |x - m| - g: values g, r (of the stiffness k), m and l.

    References
    ----------
    Hunt and Crossley (1975), doi:10.1115/1.3423596.
    """

    torque = stopped

    @staticmethod
    def constants(values: Sequence[float], context: JointContext) -> Sequence[float]:
        """Return gap, stiffness, give, middle, loss, and how the rate falls with the torque."""
        gap, ratio, middle, loss = values
        stiffness = ratio * context.stiffness
        return gap, stiffness, context.give, middle, loss, context.rate_give
