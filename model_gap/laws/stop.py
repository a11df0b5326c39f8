"""Stops to either side of a joint's twist."""

from collections.abc import Sequence

from model_gap.laws.law import JointContext, JointLaw
from model_gap.laws.solve import stopped


class StopLaw(JointLaw):
    """N = r k (x - m ∓ g) beyond ±g of the middle m: values g, r (of the stiffness k) and m."""

    torque = stopped

    @staticmethod
    def constants(values: Sequence[float], context: JointContext) -> Sequence[float]:
        """Return gap, stiffness, give and middle."""
        gap, ratio, middle = values
        return gap, ratio * context.stiffness, context.give, middle
