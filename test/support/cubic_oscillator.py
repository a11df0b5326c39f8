"""An oscillator with cubic stiffness, cubic damping and friction under white force or base.

Classical Runge-Kutta steps, eight within a sample: it shares no formula with the identifier.
"""

import math

import numba
import numpy as np
from numpy.typing import NDArray

STEPS = 8
SHARPNESS = 1e5
"""Of the force of friction over the velocity [s/m]."""


def accelerations(
    law: tuple[float, float, float, float, float],
    force: float,
    duration_s: float,
    rate_hz: float,
    rng: np.random.Generator,
    through_base: bool = False,
) -> NDArray[np.float64]:
    """Return mean accelerations within samples, (n_samples,) [m/s²].

    Parameters
    ----------
    law : (k₁, k₃, c₁, c₃, friction)
        Per mass.
    force : float [m/s^1.5]
        Root of the two-sided density of the force per mass.
    through_base : bool
        The force is that of a base which accelerates so; accelerations are over ground.
    """
    step = 1.0 / rate_hz / STEPS
    forces = rng.standard_normal(round(duration_s * rate_hz) * STEPS) * force / math.sqrt(step)
    return _run(forces, *law, step, through_base)


@numba.njit
def _acceleration(x, v, force, k1, k3, c1, c3, friction):
    return force - k1 * x - k3 * x**3 - c1 * v - c3 * v**3 - friction * math.tanh(SHARPNESS * v)


@numba.njit
def _run(forces, k1, k3, c1, c3, friction, step, through_base):
    x, v, total = 0.0, 0.0, 0.0
    found = np.empty(len(forces) // STEPS)
    for n, force in enumerate(forces):
        a1 = _acceleration(x, v, force, k1, k3, c1, c3, friction)
        v2, x2 = v + 0.5 * step * a1, x + 0.5 * step * v
        a2 = _acceleration(x2, v2, force, k1, k3, c1, c3, friction)
        v3, x3 = v + 0.5 * step * a2, x + 0.5 * step * v2
        a3 = _acceleration(x3, v3, force, k1, k3, c1, c3, friction)
        v4, x4 = v + step * a3, x + step * v3
        a4 = _acceleration(x4, v4, force, k1, k3, c1, c3, friction)
        mean = (a1 + 2.0 * a2 + 2.0 * a3 + a4) / 6.0
        x += step / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4)
        v += step * mean
        total += mean - (force if through_base else 0.0)
        if n % STEPS == STEPS - 1:
            found[n // STEPS], total = total / STEPS, 0.0
    return found
