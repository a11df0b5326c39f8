"""Responses of a cubic mode against harmonic balance and against a simulation."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from oma_identifier.levels import CubicMode

F0, ZETA = 10.0, 0.02
OMEGA = 2.0 * math.pi * F0
# Cubic parts of 5 % of the linear ones at 1 mm.
MODE = CubicMode(F0, ZETA, 0.05 * OMEGA**2 / 1e-6, 0.05 * 2.0 * ZETA * OMEGA / (OMEGA * 1e-3) ** 2)
FORCE = 0.01579137


@pytest.mark.parametrize(
    ('hz', 'linear', 'balanced', 'triple'),
    [(8.0, 1.106747e-5, 1.1067333e-5, 3.5599e-12), (10.0, 1.0e-4, 9.99582e-5, 1.5618e-9)],
)
def test_a_sine_gives_what_harmonic_balance_gives(hz, linear, balanced, triple):
    own, third = MODE.harmonics(FORCE, hz)
    assert abs(FORCE * MODE.first_order(2.0 * math.pi * hz)) == pytest.approx(linear, rel=1e-5)
    # A series of third order, against all orders of the first harmonic.
    assert abs(own) == pytest.approx(balanced, rel=2e-4)
    assert abs(third) == pytest.approx(triple, rel=2e-3)


def test_third_order_against_steps_in_time():
    """A sine at 9.5 Hz, whose series converges, 60 periods after it settled."""
    hz, force = 9.5, 0.03
    omega = 2.0 * math.pi * hz
    mode = MODE

    def slope(t, y):
        cubic = mode.cubic_stiffness * y[0] ** 3 + mode.cubic_damping * y[1] ** 3
        linear = mode.stiffness * y[0] + mode.damping * y[1]
        return [y[1], force * math.cos(omega * t) - linear - cubic]

    settled, n = 20.0, 60
    at = settled + np.arange(n * 64) / (64.0 * hz)
    x = solve_ivp(
        slope, (0.0, at[-1]), [0.0, 0.0], t_eval=at, rtol=1e-11, atol=1e-16, method='DOP853'
    ).y[0]
    own, third = mode.harmonics(force, hz)
    assert mode.converges(abs(own)) < 0.1
    for order, told in ((1, own), (3, third)):
        seen = 2.0 * np.mean(x * np.exp(-1j * order * omega * at))
        assert abs(seen - told) < 0.03 * abs(told), (order, seen, told)


def test_equivalents_of_sine_and_random_motion():
    hz, ratio = MODE.at_sine(1e-3)
    assert (hz / F0) ** 2 == pytest.approx(1.0375)
    # c₁ + 3/4 c₃ (ωq)² with ω of that amplitude.
    damping = MODE.damping + 0.75 * MODE.cubic_damping * (2.0 * math.pi * hz * 1e-3) ** 2
    assert ratio == pytest.approx(damping / (4.0 * math.pi * hz))
    assert MODE.at_random(0.5e-3)[0] == pytest.approx(hz)
    assert math.isnan(CubicMode(F0, ZETA, -MODE.cubic_stiffness).at_sine(6e-3)[0])
