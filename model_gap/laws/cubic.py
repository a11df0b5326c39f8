"""A spring that hardens or softens with its twist."""

from collections.abc import Sequence
from math import asin, asinh, sin, sinh, sqrt

from modal_core.compiled import compiled
from model_gap.laws.law import Array, Follow, JointLaw, Lane
from model_gap.laws.parabola import bent

# Of α y² and of √α y: beyond, the torque that is not linear stays as it is there.
MOST_SOFTENING = 0.6
MOST_HARDENING = 3.0


@compiled
def cubic_root(value: float, alpha: float) -> float:
    """Return y of y (1 + α y²) = value; softening, on the branch that rises, up to its end.

    References
    ----------
    Viète's trigonometric solution of the cubic, and its hyperbolic form for one real root.
    """
    size = sqrt(3.0 * abs(alpha) + 1e-30)
    scaled = 1.5 * size * value
    if alpha < 0.0:
        return 2.0 / size * sin(asin(min(max(scaled, -1.0), 1.0)) / 3.0)
    return 2.0 / size * sinh(asinh(scaled) / 3.0)


@compiled
def cubic(
    constants: Array, memory: Array, twist: float, rate: float, motor_speed: float
) -> tuple[float, float]:
    """Return the torque: with y = r + e, y + give k α y³ is what it would be without."""
    hardening, at_rest, offset = constants[0], constants[1], constants[2]
    yielding, largest = constants[3], constants[4]
    whole = min(max(cubic_root(twist + offset, yielding), -largest), largest)
    torque = hardening * (whole * whole * whole - at_rest)
    return torque, bent(memory, torque, abs(yielding) * whole * whole)


class CubicLaw(JointLaw):
    """k α ((r + e)³ - r³), r the twist at rest: k r (1 + α r²) is the preload.

    Values α [1/rad²] and the share of gravity that preloads the spring.
    """

    preloaded = True
    sees_first = Follow.MEASURED
    of_spring = True
    solve = cubic

    @staticmethod
    def constants(values: Sequence[float], lane: Lane) -> Sequence[float]:
        """Find the twist at rest and set the range: a softening spring never turns round."""
        alpha, share = values
        reach = MOST_SOFTENING if alpha < 0.0 else MOST_HARDENING**2
        largest = sqrt(reach / max(abs(alpha), 1e-30))
        rest = cubic_root(share * lane.static_twist, alpha)
        rest = min(max(rest, -largest), largest)
        hardening = lane.stiffness * alpha
        yielding = lane.give * hardening
        return hardening, rest**3, rest + yielding * rest**3, yielding, largest
