"""Play between the teeth of a gear."""

from collections.abc import Sequence

from model_gap.laws.law import Follow, JointContext, SpringLaw
from model_gap.laws.solve import play

# Of the play: teeth under less static twist than this rest between the flanks, not on one.
CENTRED = 1e-3


class BacklashLaw(SpringLaw):
    """k·dz(e + e_r, b), damped on the flanks, less the joint's linear spring and damper.

    Values b [rad] and the share of gravity preload.  Solved between the flanks, where nothing
    acts; on them the torque is constant.
    """

    sees = Follow.PARTED
    sees_screened = Follow.PARTED
    torque = play

    @staticmethod
    def constants(values: Sequence[float], context: JointContext) -> Sequence[float]:
        """Return the load, the spring, what it is on the flanks, and the damper."""
        gap, share = values
        k, rest = context.stiffness, share * context.static_twist
        place = rest + gap * min(max(rest / (CENTRED * gap), -1.0), 1.0)
        return (
            k * rest,
            k,
            context.give,
            k * (place - gap - rest),
            k * (place + gap - rest),
            context.damping,
            max(1.0 - context.give * k - context.rate_give * context.damping, 0.05),
        )
