"""Chains of masses with cubic springs or play at one or two places, linear damping, white forces.

Classical Runge-Kutta steps, eight within a sample: it shares no formula with the identifier.
"""

from dataclasses import dataclass
import math

import numba
import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

STEPS = 8
RATE_HZ = 100.0
FORCE_N = 3.0
LEVELS = (1, 2, 4, 8)
Real = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class CubicChain:
    """A chain of two to four masses; damping is that of its linear modes, by their shapes.

    Parameters
    ----------
    mass, stiffness, damping : arrays [kg], [N/m], [N s/m]
    places : (n_springs, 2) array of int
        Masses that springs lie between; -1: the ground.
    cubic, gap, beyond : (n_springs,) arrays [N/m³], [m], [N/m]
        Cubic stiffness; play on either side of the middle, and stiffness beyond it.
    frequency_hz, damping_ratio : (n,) arrays
        Of the linear chain.
    """

    seed: int
    mass: Real
    stiffness: Real
    damping: Real
    places: NDArray[np.int64]
    cubic: Real
    gap: Real
    beyond: Real
    frequency_hz: Real
    damping_ratio: Real

    def accelerations(self, level: int, duration_s: float) -> Real:
        """Return mean accelerations within samples and noise of 0.5 %, (n_samples, n)."""
        rng = np.random.default_rng([self.seed, level])
        n_steps = round(duration_s * RATE_HZ) * STEPS
        force = rng.standard_normal((n_steps, len(self.mass))) * level * FORCE_N
        found, _ = _run(self, force)
        noise = np.random.default_rng([self.seed, level, 1]).standard_normal(found.shape)
        return np.asarray(found + 0.005 * found.std(axis=0) * noise)


def random_chain(seed: int) -> CubicChain:
    """Return a chain whose springs add 3 to 50 % at the largest level; of ten three have play."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 5))
    mass, spring = 10.0 * rng.uniform(0.6, 1.6, n), rng.uniform(0.5, 2.0, n)
    stiffness = np.diag(spring + np.append(spring[1:], 0.0))
    stiffness -= np.diag(spring[1:], 1) + np.diag(spring[1:], -1)
    square, shapes = eigh(stiffness, np.diag(mass))
    highest_hz = rng.uniform(0.22, 0.32) * RATE_HZ
    scale = (2.0 * math.pi * highest_hz) ** 2 / square[-1]
    omega = np.sqrt(scale * square)
    alike = rng.random() >= 0.5
    ratio = np.full(n, rng.uniform(0.007, 0.02)) if alike else rng.uniform(0.007, 0.02, n)
    inverse = np.linalg.inv(shapes)
    n_springs = int(rng.integers(1, 3))
    at = rng.permutation(n)[:n_springs]
    places = np.array([(p, p - 1 if rng.random() < 0.5 else -1) for p in at], dtype=np.int64)
    has_play = rng.random() < 0.3
    nothing = np.zeros(len(at))
    linear = CubicChain(
        seed, mass, scale * stiffness, inverse.T @ np.diag(2.0 * ratio * omega) @ inverse,
        places, nothing, nothing, nothing, omega / (2.0 * math.pi), ratio,
    )  # fmt: skip
    force = np.random.default_rng([seed, LEVELS[-1]]).standard_normal((60_000, n))
    moves = _run(linear, force * LEVELS[-1] * FORCE_N)[1]
    strength = math.exp(rng.uniform(math.log(0.03), math.log(0.5)))
    added = scale * spring[at] * strength
    gap = moves * rng.uniform(0.2, 1.0) if has_play else nothing
    return CubicChain(
        seed, mass, linear.stiffness, linear.damping, places,
        nothing if has_play else added / (3.0 * moves**2), gap,
        2.0 * added if has_play else nothing, linear.frequency_hz, ratio,
    )  # fmt: skip


def _run(chain: CubicChain, force: Real) -> tuple[Real, Real]:
    """Return accelerations, and root mean squares of what springs are stretched by."""
    return _steps(  # type: ignore[no-any-return]
        force, 1.0 / RATE_HZ / STEPS, chain.mass, chain.stiffness, chain.damping, chain.places,
        chain.cubic, chain.gap, chain.beyond,
    )  # fmt: skip


@numba.njit
def _acceleration(x, v, force, mass, stiffness, damping, places, cubic, gap, beyond):
    n = len(x)
    total = np.empty(n)
    for i in range(n):
        total[i] = force[i]
        for j in range(n):
            total[i] -= stiffness[i, j] * x[j] + damping[i, j] * v[j]
    for p in range(len(places)):
        i, j = places[p]
        stretch = x[i] - (x[j] if j >= 0 else 0.0)
        pull = cubic[p] * stretch**3
        if beyond[p] > 0.0:
            pull += beyond[p] * (max(stretch - gap[p], 0.0) + min(stretch + gap[p], 0.0))
        total[i] -= pull
        if j >= 0:
            total[j] += pull
    return total / mass


@numba.njit
def _steps(forces, h, mass, stiffness, damping, places, cubic, gap, beyond):
    n = len(mass)
    law = (mass, stiffness, damping, places, cubic, gap, beyond)
    x, v, total = np.zeros(n), np.zeros(n), np.zeros(n)
    found, squares = np.empty((len(forces) // STEPS, n)), np.zeros(len(places))
    for t in range(len(forces)):
        force = forces[t]
        a1 = _acceleration(x, v, force, *law)
        v2, x2 = v + 0.5 * h * a1, x + 0.5 * h * v
        a2 = _acceleration(x2, v2, force, *law)
        v3, x3 = v + 0.5 * h * a2, x + 0.5 * h * v2
        a3 = _acceleration(x3, v3, force, *law)
        v4, x4 = v + h * a3, x + h * v3
        a4 = _acceleration(x4, v4, force, *law)
        mean = (a1 + 2.0 * a2 + 2.0 * a3 + a4) / 6.0
        x = x + h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4)
        v = v + h * mean
        total += mean
        for p in range(len(places)):
            i, j = places[p]
            squares[p] += (x[i] - (x[j] if j >= 0 else 0.0)) ** 2
        if t % STEPS == STEPS - 1:
            found[t // STEPS] = total / STEPS
            total = np.zeros(n)
    return found, np.sqrt(squares / len(forces))
