"""Friction of a gear or between two links."""

from collections.abc import Sequence
from math import exp, log1p, tanh

from modal_core.compiled import compiled
from model_gap.laws.law import Array, JointLaw, Lane

MOST_NEWTON_STEPS = 20
SOLVED = 1e-9


@compiled
def sliding(free: float, braking: float, width: float) -> float:
    """Solve w + b tanh(w/v₀) = v >= 0 for the sliding speed w that is left.

    tanh(x) is less than x and than one: the larger of both bounds is below the root, from where
    Newton's steps on the concave function climb to it.
    """
    left = max(free - braking, free / (1.0 + braking / width))
    for _ in range(MOST_NEWTON_STEPS):
        grip = tanh(left / width)
        slope = 1.0 + braking / width * (1.0 - grip * grip)
        climb = (free - left - braking * grip) / slope
        left += climb
        if climb < SOLVED * width:
            break
    return left


@compiled
def log_cosh(x: float) -> float:
    """Return ln cosh(x), up to a constant."""
    return abs(x) + log1p(exp(-2.0 * abs(x)))


@compiled
def friction(
    constants: Array, memory: Array, twist: float, rate: float, motor_speed: float
) -> tuple[float, float]:
    """Return the torque at a sliding speed, and the surplus.

    The speed runs straight: its sign turns between steps, not at one.

    References
    ----------
    Parker, Zavalishin and Le Bivic (2016), antiderivative antialiasing, DAFx-16, eq. 10.
    """
    level, width, braking, yielding = constants[0], constants[1], constants[2], constants[3]
    before, last, last_speed = memory[0], memory[1], memory[2]
    free = rate + yielding * (4.0 * last - before)
    speed = sliding(abs(free), braking, width)
    if free < 0.0:
        speed = -speed
    torque = level * tanh(speed / width)
    change = speed - last_speed
    surplus = 0.0
    if abs(change) > 1e-3 * width:
        mean = level * width * (log_cosh(speed / width) - log_cosh(last_speed / width)) / change
        surplus = mean - 0.5 * (last + torque)
    memory[0], memory[1], memory[2] = last, torque, speed
    return torque, surplus


@compiled
def joint_friction(
    constants: Array, memory: Array, twist: float, rate: float, motor_speed: float
) -> tuple[float, float]:
    """Return the same on the whole speed of the joint."""
    return friction(constants, memory, twist, rate + motor_speed, motor_speed)


class FrictionLaw(JointLaw):
    """F = τ·tanh(w/v₀) of the sliding speed w = v - p F'/k, k the joint's stiffness.

    Coulomb friction with a viscous transition, behind a spring: before it slides it gives way.
    Values τ, v₀ and p.  In steps of h, F' is (3F - 4F₁ + F₂)/2h, F₁ and F₂ the torques before:
    the spring slows the sliding like a further share 3p/(2hk) of the torque.

    References
    ----------
    Implicit steps: Curtiss and Hirschfelder (1952), doi:10.1073/pnas.38.3.235.
    """

    solve = friction

    @staticmethod
    def constants(values: Sequence[float], lane: Lane) -> Sequence[float]:
        """Return how much the torque slows the sliding within a step."""
        level, width, compliance = values
        yielding = 0.5 * compliance / (lane.period_s * lane.stiffness)
        braking = (lane.rate_give + 3.0 * yielding) * level
        return level, width, braking, yielding


class JointFrictionLaw(FrictionLaw):
    """The same on the whole joint speed: friction between two links."""

    solve = joint_friction
