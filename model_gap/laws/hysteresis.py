"""A spring beside the joint's own that slips."""

from collections.abc import Sequence

from model_gap.laws.law import JointContext, JointLaw
from model_gap.laws.solve import slipping


class HysteresisLaw(JointLaw):
    """N = s k z, z follows the twist between ±x_y: values s (share of the stiffness k) and x_y.

    References
    ----------
    Iwan (1966), doi:10.1115/1.3625199 (one Jenkin element beside a spring).
    """

    torque = slipping

    @staticmethod
    def constants(values: Sequence[float], context: JointContext) -> Sequence[float]:
        """Return stiffness, limit and give."""
        share, limit = values
        return max(share, 1e-9) * context.stiffness, limit, context.give
