"""Torques in gears, beside linear springs: from other equations than the suite's own.

A law sees time, the twists of all gears [rad], their rates, the motors' motion and its own
states; it returns torques on the gears and the states' derivatives.
"""

from dataclasses import dataclass
import math

import numpy as np

GEARS = 6
FASTEST_1_S = 9000.0  # twice the rate of the finest steps


def _on(gear, torque):
    found = np.zeros(GEARS)
    found[gear] = torque
    return found


@dataclass
class Law:
    """A torque in one gear, of stiffness k."""

    gear: int
    k: float
    states: int = 0
    finer: int = 1  # steps in one of the engine's own

    def begin(self, twist):
        """Return the states of a gear that hangs still."""
        return np.zeros(self.states)

    def at_rest(self, twist):
        """Return the torque on every gear that hangs still."""
        return np.zeros(GEARS)

    def torque(self, time, twist, rate, position, velocity, inner):
        """Return torques on every gear and the derivative of the states."""
        raise NotImplementedError


@dataclass
class Friction(Law):
    """A bristle that gives way before it slides: F' = s v (1 - F sign(v)/c).

    Dahl (1968), TOR-0158(3107-18)-1, exponent 1; with c(v) it is the Stribeck curve as well:
    LuGre without damping, Canudas de Wit et al. (1995), doi:10.1109/9.376053.
    """

    level: float = 0.0
    bristle: float = 0.0
    static: float = 0.0
    speed: float = 5e-3
    share: float = 0.0  # of the torque the gear carries
    states: int = 1
    finer: int = 3

    def torque(self, time, twist, rate, position, velocity, inner):
        v = rate[self.gear]
        level = self.level + self.share * abs(self.k * twist[self.gear])
        if self.static > level:
            level += (self.static - level) * math.exp(-((v / self.speed) ** 2))
        # s (v - F |v|/c) = r (c sign(v) - F): what turns over in 0.1 ms is Coulomb's.
        turning = min(self.bristle * abs(v) / level, FASTEST_1_S)
        change = turning * (math.copysign(level, v) - inner[0])
        return _on(self.gear, -inner[0]), np.array([change])


@dataclass
class Play(Law):
    """Two flanks that touch or do not: the gear's spring and damper act only in contact."""

    half: float = 0.0
    c: float = 0.0

    def _carried(self, e):
        return self.k * (max(e - self.half, 0.0) + min(e + self.half, 0.0))

    def at_rest(self, twist):
        e = twist[self.gear]
        return _on(self.gear, self.k * e - self._carried(e))

    def torque(self, time, twist, rate, position, velocity, inner):
        e, v = twist[self.gear], rate[self.gear]
        free = abs(e) < self.half
        return _on(self.gear, self.k * e - self._carried(e) + (self.c * v if free else 0.0)), ()


@dataclass
class Rod(Law):
    """A spring over the twists of two joints, which their motors carry along: a driven rod.

    One that held the links themselves would keep the motors from moving them.
    """

    stiffness: float = 0.0
    loss_s: float = 0.0
    row: np.ndarray | None = None  # of gears: how far they stretch it

    def at_rest(self, twist):
        return -self.row * self.stiffness * float(self.row @ twist)

    def torque(self, time, twist, rate, position, velocity, inner):
        return self.at_rest(twist + self.loss_s * rate), ()


@dataclass
class Hardening(Law):
    """Gears whose stiffness is k (1 + 3 a e²): the torque is its integral."""

    a: float = 0.0

    def at_rest(self, twist):
        return _on(self.gear, -self.k * self.a * twist[self.gear] ** 3)

    def torque(self, time, twist, rate, position, velocity, inner):
        return self.at_rest(twist), ()


@dataclass
class Lopsided(Law):
    """Stiffer one way than the other: k (1 ± s), which no law of the catalogue describes."""

    s: float = 0.0

    def at_rest(self, twist):
        return _on(self.gear, -self.k * self.s * abs(twist[self.gear]))

    def torque(self, time, twist, rate, position, velocity, inner):
        return self.at_rest(twist), ()


@dataclass
class SpeedStiffening(Law):
    """Stiffness that grows with the motor's speed."""

    beta: float = 0.0

    def torque(self, time, twist, rate, position, velocity, inner):
        speed = abs(velocity[self.gear])
        return _on(self.gear, -self.k * self.beta * speed * twist[self.gear]), ()


@dataclass
class BoucWen(Law):
    """A spring that slips smoothly: z' = v (1 - |z/l|² (1 + sign(v z))/2) (Wen 1976)."""

    share: float = 0.0
    limit: float = 1e-4
    states: int = 1

    def torque(self, time, twist, rate, position, velocity, inner):
        v, z = rate[self.gear], inner[0]
        part = 1.0 if v * z > 0.0 else 0.0
        change = v * (1.0 - part * (z / self.limit) ** 2)
        return _on(self.gear, -self.share * self.k * z), np.array([change])


@dataclass
class Stop(Law):
    """Buffers: a spring that is damped while it is pressed (Hunt and Crossley 1975)."""

    gap: float = 0.0
    buffer: float = 0.0
    loss: float = 0.0
    states: int = 1

    def begin(self, twist):
        return np.array([twist[self.gear]])

    def torque(self, time, twist, rate, position, velocity, inner):
        e = twist[self.gear] - inner[0]
        deep = max(abs(e) - self.gap, 0.0)
        side = math.copysign(1.0, e)
        pushed = self.buffer * deep * max(1.0 + self.loss * side * rate[self.gear], 0.0)
        return _on(self.gear, -side * pushed), np.zeros(1)


@dataclass
class FastDamping(Law):
    """A damper whose torque grows with the cube of the speed: fast motion makes it stiff."""

    c: float = 0.0
    finer: int = 6

    def torque(self, time, twist, rate, position, velocity, inner):
        v = rate[self.gear]
        return _on(self.gear, -self.c * v * v * v), ()


@dataclass
class Ripple(Law):
    """A gear whose output runs ahead by a ripple over the motor's turn."""

    amplitude: float = 0.0
    order: float = 1.0
    at: float = 0.0
    row: np.ndarray | None = None

    def torque(self, time, twist, rate, position, velocity, inner):
        turned = self.order * (self.at + float(self.row @ position))
        ahead = math.sin(turned) - math.sin(self.order * self.at)
        return _on(self.gear, self.k * self.amplitude * ahead), ()


@dataclass
class Hum(Law):
    """A torque at one frequency, whatever the arm does."""

    size: float = 0.0
    f: float = 0.0
    phase: float = 0.0

    def torque(self, time, twist, rate, position, velocity, inner):
        angle = 2.0 * math.pi * self.f * time + self.phase
        return _on(self.gear, self.size * math.cos(angle)), ()


@dataclass
class Softening(Law):
    """Stiffness that falls as time goes on: the gear gets warm."""

    rate: float = 0.0  # of the stiffness, 1/s

    def torque(self, time, twist, rate, position, velocity, inner):
        return _on(self.gear, self.k * self.rate * time * twist[self.gear]), ()


@dataclass
class Servo:
    """Motors that follow a command: rotors of their own on their controllers' springs."""

    k: np.ndarray
    c: np.ndarray
    rotors: np.ndarray
    omega: float
    zeta: float
    states: int = 2 * GEARS
    finer: int = 1

    def begin(self, twist):
        # The controller integrates: a motor that hangs still is where it should be.
        return np.zeros(self.states)

    def at_rest(self, twist):
        return np.zeros(GEARS)

    def torque(self, time, twist, rate, position, velocity, inner):
        lag, late = inner[:GEARS], inner[GEARS:]
        changed = self.k * lag + self.c * late
        torque = self.k * (twist - lag) + self.c * (rate - late)
        held = self.k * self._hanging(twist)
        push = torque - held
        return changed, np.concatenate(
            [late, push / self.rotors - 2.0 * self.zeta * self.omega * late - self.omega**2 * lag]
        )

    def _hanging(self, twist):
        if not hasattr(self, 'hanging'):
            self.hanging = twist.copy()
        return self.hanging
