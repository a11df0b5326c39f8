"""Friction that depends on speed and load: more before it slides fast, more under load."""

from collections.abc import Sequence
from math import exp, log1p, tanh

from modal_core.work.compiled import compiled
from model_gap.laws.law import Array, JointContext, JointLaw

MOST_STEPS = 60
SOLVED = 1e-9
# Gauss and Legendre's three points of the mean over a step, where the curve has no integral.
POINTS = (-0.7745966692414834, 0.0, 0.7745966692414834)
WEIGHTS = (5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0)


@compiled
def grip(speed: float, width: float, rise: float, knee: float) -> float:
    """Return the torque at a sliding speed as a part of that at high speed."""
    ratio = speed / knee
    return tanh(speed / width) * (1.0 + rise * exp(-ratio * ratio))


@compiled
def slid(free: float, braking: float, width: float, rise: float, knee: float) -> float:
    """Solve w + b grip(w) = v >= 0 for the sliding speed w that is left.

    The curve falls: bisection holds what Newton's steps would leave.
    """
    low, high = 0.0, free
    left = free / (1.0 + braking * (1.0 + rise) / width)
    for _ in range(MOST_STEPS):
        held = grip(left, width, rise, knee)
        over = left + braking * held - free
        if over > 0.0:
            high = left
        else:
            low = left
        step = 1e-4 * width
        slope = 1.0 + braking * (grip(left + step, width, rise, knee) - held) / step
        following = left - over / slope if slope > 0.0 else low - 1.0
        if not low < following < high:
            following = 0.5 * (low + high)
        if abs(following - left) < SOLVED * width:
            return following
        left = following
    return left


@compiled
def curve(
    constants: Array, memory: Array, twist: float, rate: float, motor_speed: float
) -> tuple[float, float]:
    """Return the torque at a sliding speed under a load, and the surplus.

    The mean over a step in which the speed runs straight: of tanh in closed form, of what the
    curve adds to it at three points.
    """
    level, width, rate_give = constants[0], constants[1], constants[2]
    rise, knee = constants[3], constants[4]
    per_load, stiffness, at_rest = constants[5], constants[6], constants[7]
    yielding = constants[8]
    size = level + per_load * abs(stiffness * (at_rest + twist))
    free = rate + yielding * (4.0 * memory[2] - memory[3])
    speed = slid(abs(free), (rate_give + 3.0 * yielding) * size, width, rise, knee)
    if free < 0.0:
        speed = -speed
    held = grip(speed, width, rise, knee)
    before, last = memory[0], memory[1]
    change = speed - before
    surplus = 0.0
    if abs(change) > 1e-3 * width:
        one, two = abs(speed) / width, abs(before) / width
        cosh_one, cosh_two = one + log1p(exp(-2.0 * one)), two + log1p(exp(-2.0 * two))
        mean = width * (cosh_one - cosh_two) / change
        if rise != 0.0:
            for number in range(3):
                at = before + 0.5 * (1.0 + POINTS[number]) * change
                mean += WEIGHTS[number] * (
                    grip(at, width, rise, knee) - grip(at, width, 0.0, knee)
                )
        surplus = size * (mean - 0.5 * (last + held))
    memory[0], memory[1], memory[2], memory[3] = speed, held, size * held, memory[2]
    return size * held, surplus


@compiled
def whole_curve(
    constants: Array, memory: Array, twist: float, rate: float, motor_speed: float
) -> tuple[float, float]:
    """Return the torque at the whole joint's speed, and the surplus."""
    return curve(constants, memory, twist, rate + motor_speed, motor_speed)


class FrictionCurveLaw(JointLaw):
    """F = (τ + μ|k (r + e)|)·(1 + s exp(-(w/v_s)²))·tanh(w/v₀), w = v - p F'/k the sliding speed.

    Values τ, v₀, s, v_s, μ, p; r is the twist at rest, k the joint's stiffness, v the twist's
    rate.  Before it slides it gives way, in steps as ``FrictionLaw`` says.

    References
    ----------
    Armstrong-Hélouvry et al. (1994), doi:10.1016/0005-1098(94)90209-7; load: Hamon, Gautier and
    Garrec (2010), doi:10.1109/IROS.2010.5649189.
    """

    torque = curve

    @staticmethod
    def constants(values: Sequence[float], context: JointContext) -> Sequence[float]:
        """Return the values, how the rate falls with the torque, the load at rest, what gives."""
        level, width, rise, knee, per_load, compliance = values
        load = per_load, context.stiffness, context.static_twist
        yielding = context.yielding(compliance)
        return level, width, context.rate_give, rise, knee, *load, yielding


class WholeFrictionCurveLaw(FrictionCurveLaw):
    """The same on the whole joint speed: friction between two links."""

    torque = whole_curve
