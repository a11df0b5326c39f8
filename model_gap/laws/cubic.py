"""A spring that hardens or softens with its twist."""

from collections.abc import Sequence
from math import sqrt

from model_gap.laws.law import JointContext, SpringLaw
from model_gap.laws.solve import cubic, cubic_root

# Of α y² and of √α y: beyond, the torque that is not linear stays as it is there.
MOST_SOFTENING = 0.6
MOST_HARDENING = 3.0


class CubicLaw(SpringLaw):
    """k α ((r + e)³ - r³), r the twist at rest: k r (1 + α r²) is the preload.

    Values α [1/rad²] and the share of gravity that preloads the spring.
    """

    torque = cubic

    @staticmethod
    def constants(values: Sequence[float], context: JointContext) -> Sequence[float]:
        """Find the twist at rest and set the range: a softening spring never turns round."""
        alpha, share = values
        reach = MOST_SOFTENING if alpha < 0.0 else MOST_HARDENING**2
        largest = sqrt(reach / max(abs(alpha), 1e-30))
        rest = cubic_root(share * context.static_twist, alpha)
        rest = min(max(rest, -largest), largest)
        hardening = context.stiffness * alpha
        yielding = context.give * hardening
        return hardening, rest**3, rest + yielding * rest**3, yielding, largest
