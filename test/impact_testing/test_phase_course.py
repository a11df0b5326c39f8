"""The course of a wandering phase against the same model written out with full matrices."""

import numpy as np
import pytest

from impact_testing.phase_course import course_of

STEP_S = 0.125
PACES = (0.0, 1e-3, 0.03, 0.1, 0.5)


def dense(seen, variance):
    """Return course and variance by the covariance of the integral of a random walk.

    Rasmussen and Williams (2006), Gaussian Processes for Machine Learning, eq. 2.41 to 2.45.
    """
    time_s = STEP_S * np.arange(1, len(seen) + 1)
    late, early = np.maximum.outer(time_s, time_s), np.minimum.outer(time_s, time_s)
    walk = early**2 * late / 2.0 - early**3 / 6.0
    free = np.stack([np.ones_like(time_s), time_s], axis=1)
    tried = []
    for pace in PACES:
        own = pace**2 * walk
        inverse = np.linalg.inv(own + np.diag(variance))
        gram = free.T @ inverse @ free
        level = np.linalg.solve(gram, free.T @ inverse @ seen)
        left = seen - free @ level
        cost = left @ inverse @ left - np.linalg.slogdet(inverse)[1] + np.linalg.slogdet(gram)[1]
        beside = free - own @ inverse @ free
        spread = np.diag(own - own @ inverse @ own)
        spread = spread + np.diag(beside @ np.linalg.solve(gram, beside.T))
        tried.append((cost, free @ level + own @ inverse @ left, spread))
    return min(tried, key=lambda each: each[0])[1:]


@pytest.mark.parametrize('pace', PACES)
@pytest.mark.parametrize('seed', range(710100, 710104))
def test_course_and_variance_are_those_of_full_matrices(pace, seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(8, 200))
    frequency = np.cumsum(pace * np.sqrt(STEP_S) * rng.standard_normal(n))
    variance = 10.0 ** rng.uniform(-3.0, 1.0, n)
    variance[rng.random(n) < 0.2] = 1e6  # blocks in which nothing is seen
    seen = np.cumsum(frequency) * STEP_S + np.sqrt(np.minimum(variance, 1e4)) * (
        rng.standard_normal(n)
    )
    course, spread = course_of(STEP_S, seen, variance, PACES)
    expected, expected_spread = dense(seen, variance)
    assert course == pytest.approx(expected, abs=1e-6 * np.abs(expected).max()), f'seed {seed}'
    assert spread == pytest.approx(expected_spread, rel=1e-4), f'seed {seed}'
