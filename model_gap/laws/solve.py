"""The laws' equations solved implicitly, as machine code.

Each takes (constants, memory, twist, rate, motor_speed) and returns the torque N beyond the linear
spring's at the end of a step, and the surplus:

constants : (n_constants,) array
    ``JointLaw.constants``.
memory : (MEMORY,) array
    The law's own, zero before the first step.
twist, rate : float [rad], [rad/s]
    What they would be without N; they fall by ``give`` N and ``rate_give`` N with it.
motor_speed : float [rad/s]
    Of the joint.
N, surplus : float [N m]
    The surplus is the mean torque over the step less the mean of its ends.

In one file with what they share: what is kept of a compiled function is forgotten only when its
own file changes.
"""

from math import asin, asinh, exp, log, log1p, sin, sinh, sqrt

from modal_core.work.compiled import compiled
from model_gap.laws.law import Array

MOST_NEWTON_STEPS = 20
LN_2 = log(2.0)
SOLVED = 1e-9
# Third of the give times what the spring stiffens by: beyond, no parabola follows its steps.
STEEPEST = 0.03
# Longest path that a spring's slip is followed along, in limits: of the last limit 0.3 % is left
# then at n = 0.7, 0.03 % at n = 1 and 2e-7 at n = 2.
SATURATED = 8.0


@compiled
def sliding(free: float, braking: float) -> float:
    """Solve x + b tanh(x) = v >= 0 for the sliding speed x that is left, in transition speeds.

    tanh(x) is less than x and than one: the larger of both bounds is below the root, from where
    Newton's steps on the concave function climb to it.
    """
    left = max(free - braking, free / (1.0 + braking))
    for _ in range(MOST_NEWTON_STEPS):
        part = exp(-2.0 * left)
        inverse = 1.0 / (1.0 + part)
        grip = (1.0 - part) * inverse
        slope = 1.0 + 4.0 * braking * part * inverse * inverse
        climb = (free - left - braking * grip) / slope
        left += climb
        if climb < SOLVED:
            break
    return left


@compiled
def friction(
    constants: Array, memory: Array, twist: float, rate: float, motor_speed: float
) -> tuple[float, float]:
    """Return the torque at a sliding speed, and the surplus.

    The speed runs straight: its sign turns between steps, not at one.  Speeds are in transition
    speeds; one exponential gives both the torque's tanh and its integral, ln cosh.

    References
    ----------
    Parker, Zavalishin and Le Bivic (2016), antiderivative antialiasing, DAFx-16, eq. 10.
    """
    level, width, braking, yielding = constants[0], constants[1], constants[2], constants[3]
    before, last, last_speed, last_integral = memory[0], memory[1], memory[2], memory[3]
    free = (rate + yielding * (4.0 * last - before)) / width
    left = sliding(abs(free), braking / width)
    part = exp(-2.0 * left)
    torque = level * (1.0 - part) / (1.0 + part)
    integral = left + log1p(part) - LN_2
    speed = left
    if free < 0.0:
        speed, torque = -left, -torque
    change = speed - last_speed
    surplus = 0.0
    if abs(change) > 1e-3:
        surplus = level * (integral - last_integral) / change - 0.5 * (last + torque)
    memory[0], memory[1], memory[2], memory[3] = last, torque, speed, integral
    return torque, surplus


@compiled
def joint_friction(
    constants: Array, memory: Array, twist: float, rate: float, motor_speed: float
) -> tuple[float, float]:
    """Return the torque at the whole joint's speed, and the surplus."""
    return friction(constants, memory, twist, rate + motor_speed, motor_speed)


@compiled
def bent(memory: Array, torque: float, steep: float) -> float:
    """Return the mean over the last step less that of its ends.

    A line takes (ω h)²/12 off what may be a large part of the stiffness.  Where a step hardly
    resolves the stiffened joint the parabola would run away: the line stays.

    Parameters
    ----------
    memory : (MEMORY,) array
        The last two torques and steeps.
    torque : float [N m]
        At the end of the step.
    steep : float
        Give times what the spring is stiffened by.
    """
    bend = max(steep, memory[2], memory[3]) / STEEPEST
    before, last = memory[0], memory[1]
    memory[0], memory[1], memory[2], memory[3] = last, torque, memory[3], steep
    return float((last + last - before - torque) / (12.0 + 12.0 * bend * bend))


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


@compiled
def play(
    constants: Array, memory: Array, twist: float, rate: float, motor_speed: float
) -> tuple[float, float]:
    """Return the torque: between the flanks neither spring nor damper acts.

    Where it is neither between them nor pressed on one, teeth slide along that.
    """
    load, k, give = constants[0], constants[1], constants[2]
    lower, upper, damping, eased = constants[3], constants[4], constants[5], constants[6]
    between = -(load + k * twist + damping * rate) / eased
    sprung = -load - k * (twist - give * between)
    if sprung > upper:
        if -load - k * (twist - give * upper) >= upper:
            return upper, 0.0
        return (twist + (upper + load) / k) / give, 0.0
    if sprung < lower:
        if -load - k * (twist - give * lower) <= lower:
            return lower, 0.0
        return (twist + (lower + load) / k) / give, 0.0
    return between, 0.0


@compiled
def speed_spring(
    constants: Array, memory: Array, twist: float, rate: float, motor_speed: float
) -> tuple[float, float]:
    """Return the torque: linear in the twist."""
    change, rest, give = constants[0], constants[1], constants[2]
    added = change * abs(motor_speed)
    torque = added * (rest + twist) / max(1.0 + give * added, 0.2)
    return torque, bent(memory, torque, abs(give * added))


@compiled
def loaded(part: float, path: float, knee: float) -> float:
    """Return what a part of a limit becomes along a path in limits, u' = 1 - uⁿ from u >= 0.

    In classical steps of 1/n at most, the width of the knee: along up to two limits they are
    right to 0.08 % of one at n = 1, less at sharper knees, and to 0.4 % at n = 0.7.
    """
    path = min(path, SATURATED)
    count = int(path * knee) + 1
    step = path / count
    for _ in range(count):
        first = 1.0 - part**knee
        second = 1.0 - min(part + 0.5 * step * first, 1.0) ** knee
        third = 1.0 - min(part + 0.5 * step * second, 1.0) ** knee
        last = 1.0 - min(part + step * third, 1.0) ** knee
        part = min(part + step / 6.0 * (first + 2.0 * (second + third) + last), 1.0)
    return part


@compiled
def bouc_wen(part: float, path: float, knee: float) -> float:
    """Return z/l behind a path in limits: it unloads straight, and loads along its knee.

    References
    ----------
    Wen (1976), doi:10.1061/JMCEA3.0002106, with A = 1 and β = γ = 1/2 lⁿ.
    """
    side = 1.0 if path > 0.0 else -1.0
    ahead, left = side * part, abs(path)
    if ahead < 0.0:
        back = min(-ahead, left)
        ahead, left = ahead + back, left - back
    return side * loaded(ahead, left, knee) if left > 0.0 else side * ahead


@compiled
def slipping(
    constants: Array, memory: Array, twist: float, rate: float, motor_speed: float
) -> tuple[float, float]:
    """Return the torque of a spring that slips: it follows the twist up to its limit.

    The part z/l of its limit solves z/l = B(x - e z/l) with e what the twist gives, in limits: B
    climbs by one at most, and Newton's steps are kept between what is known of both sides.
    """
    stiffness, limit, give, knee = constants[0], constants[1], constants[2], constants[3]
    before, path = memory[0], (twist - memory[1]) / limit
    eased = give * stiffness
    low, high = -1.0, 1.0
    part = min(max((before + path) / (1.0 + eased), low), high)
    for _ in range(MOST_NEWTON_STEPS):
        there = bouc_wen(before, path - eased * part, knee)
        over = part - there
        if abs(over) < SOLVED:
            break
        if over > 0.0:
            high = part
        else:
            low = part
        slope = 1.0 - abs(there) ** knee if (path - eased * part) * there > 0.0 else 1.0
        following = part - over / (1.0 + eased * slope)
        part = following if low < following < high else 0.5 * (low + high)
    torque = stiffness * limit * part
    memory[0], memory[1] = part, twist - give * torque
    return torque, 0.0


@compiled
def stopped(
    constants: Array, memory: Array, twist: float, rate: float, motor_speed: float
) -> tuple[float, float]:
    """Return the torque of stops to either side of a middle, damped while they are pressed.

    N = r k d (1 + l v) of depth d and its rate v, both less by their give times N: the smaller
    root of a quadratic.  A stop never pulls.

    References
    ----------
    Hunt and Crossley (1975), doi:10.1115/1.3423596.
    """
    gap, stiffness, give, middle = constants[0], constants[1], constants[2], constants[3]
    loss, rate_give = constants[4], constants[5]
    beyond = max(twist - middle - gap, 0.0) + min(twist - middle + gap, 0.0)
    depth = abs(beyond)
    grows = 1.0 + loss * (rate if beyond > 0.0 else -rate)
    torque = 0.0
    if depth > 0.0 and grows > 0.0:
        eased = loss * rate_give
        first = 1.0 + stiffness * (give * grows + depth * eased)
        held = first * first - 4.0 * stiffness * stiffness * give * eased * depth * grows
        torque = 2.0 * stiffness * depth * grows / (first + sqrt(max(held, 0.0)))
        if beyond < 0.0:
            torque = -torque
    return torque, 0.0


@compiled
def cubic_damper(
    constants: Array, memory: Array, twist: float, rate: float, motor_speed: float
) -> tuple[float, float]:
    """Return the torque c v³, v what the damper leaves of the rate."""
    coefficient, rate_give = constants[0], constants[1]
    speed = cubic_root(rate, rate_give * coefficient)
    return coefficient * speed * speed * speed, 0.0
