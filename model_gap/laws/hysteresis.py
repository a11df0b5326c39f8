"""A spring beside the joint's own that slips."""

from collections.abc import Sequence

from model_gap.laws.law import JointContext, JointLaw
from model_gap.laws.solve import slipping


class HysteresisLaw(JointLaw):
    """N = s k z, z' = x' (1 - |z/x_y|ⁿ (1 + sign(x' z))/2): values s (share of k), x_y and n.

    References
    ----------
    Wen (1976), doi:10.1061/JMCEA3.0002106; sharp, with n large, it is the element of Iwan (1966),
    doi:10.1115/1.3625199.
    """

    torque = slipping

    @staticmethod
    def constants(values: Sequence[float], context: JointContext) -> Sequence[float]:
        """Return stiffness, limit, give and knee."""
        share, limit, knee = values
        return max(share, 1e-9) * context.stiffness, limit, context.give, knee
