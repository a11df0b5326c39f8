"""Friction of a gear or between two links."""

from collections.abc import Sequence

from model_gap.laws.law import JointContext, JointLaw
from model_gap.laws.solve import friction, joint_friction


class FrictionLaw(JointLaw):
    """F = τ·tanh(w/v₀) of the sliding speed w = v - p F'/k, k the joint's stiffness.

    Coulomb friction with a viscous transition, behind a spring: before it slides it gives way.
    Values τ, v₀ and p.  In steps of h, F' is (3F - 4F₁ + F₂)/2h, F₁ and F₂ the torques before:
    the spring slows the sliding like a further share 3p/(2hk) of the torque.

    References
    ----------
    Implicit steps: Curtiss and Hirschfelder (1952), doi:10.1073/pnas.38.3.235.
    """

    torque = friction

    @staticmethod
    def constants(values: Sequence[float], context: JointContext) -> Sequence[float]:
        """Return how much the torque slows the sliding within a step."""
        level, width, compliance = values
        yielding = context.yielding(compliance)
        braking = (context.rate_give + 3.0 * yielding) * level
        return level, width, braking, yielding


class JointFrictionLaw(FrictionLaw):
    """The same on the whole joint speed: friction between two links."""

    torque = joint_friction
