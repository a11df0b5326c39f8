"""What is left of a friction that sticks, against the closed form of Dahl's equation."""

import numpy as np
import pytest

from benchmarks.states import friction_slope, SLIPS_RAD


def sweeps(n_strokes, length_rad, n_steps):
    """Return a path to and fro between 0 and a length, one column."""
    corners = np.arange(n_strokes + 1) % 2 * length_rad
    places = np.arange(n_strokes * n_steps + 1) / n_steps
    return np.interp(places, np.arange(n_strokes + 1), corners)[:, None]


def test_standing_joints_keep_their_friction():
    still = 0.01 * SLIPS_RAD * np.sin(np.arange(2000.0))[:, None]
    assert friction_slope(still) == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize('lengths', [10.0, 30.0, 100.0])
@pytest.mark.slow
def test_each_turn_costs_twice_the_presliding_travel(lengths):
    n = 40
    path = sweeps(n, lengths * SLIPS_RAD, round(100 * lengths))
    # From slack at first: 1; then from one end of the friction to the other: 2.
    assert friction_slope(path) == pytest.approx((1 + 2 * (n - 1)) / (n * lengths), rel=0.01)
