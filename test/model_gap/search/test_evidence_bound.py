"""When there is nothing left to look for: misfit at the noise, tolerances as chance draws them."""

import numpy as np
import pytest

from model_gap.fit.fit import Fit
from model_gap.search.evidence_bound import evidence_bound, tolerance_excess

SEED = 8
SIZE = 40


class Found:
    """A hypothesis of which only the tolerances matter."""

    def __init__(self, values):
        self.tolerance_values = values


def fit_of(values, precision):
    return Fit(Found(values), 0.99, 0.0, np.zeros((0, 0)), precision)


@pytest.fixture(scope='module')
def posterior():
    """Draw deviations and fit them to data that tell some directions well and others not."""
    rng = np.random.default_rng(SEED)
    turn = np.linalg.qr(rng.standard_normal((SIZE, SIZE)))[0]
    weights = np.geomspace(1e-2, 1e4, SIZE)
    precision = np.eye(SIZE) + (turn * weights) @ turn.T

    def draw(extra=0.0):
        true = rng.standard_normal(SIZE) + extra * turn[:, -1]
        # Tempered: the data's own errors are far smaller than the precision says.
        pull = (turn * weights) @ turn.T @ true
        return fit_of(np.linalg.solve(precision, pull), precision)

    return draw


def test_chance_leaves_the_excess_that_two_deviations_allow(posterior):
    """Well known directions cost half a chi-square: here about 28 of them."""
    excess = np.array([tolerance_excess(posterior()) for _ in range(400)])
    weights = np.geomspace(1e-2, 1e4, SIZE)
    found = weights / (1.0 + weights)
    deviation = np.sqrt(0.5 * np.sum(found**4))
    assert excess.mean() == pytest.approx(2.0 * deviation, rel=0.1), f'seed {SEED}'
    assert excess.std() == pytest.approx(deviation, rel=0.15), f'seed {SEED}'
    assert np.mean(excess < 12.0) > 0.85, f'seed {SEED}'
    assert evidence_bound(posterior()) == 0.0


def test_a_tolerance_that_hides_an_effect_leaves_one(posterior):
    # Seven deviations are 24 units of log evidence: enough to look further.
    excess = np.array([tolerance_excess(posterior(7.0)) for _ in range(400)])
    assert np.mean(excess > 12.0) > 0.95, f'seed {SEED}: {np.sort(excess)[:20]}'


def test_details_beside_the_tolerances_change_nothing(posterior):
    found = posterior()
    wide = np.eye(SIZE + 2)
    wide[:SIZE, :SIZE] = found.precision
    more = fit_of(found.hypothesis.tolerance_values, wide)
    assert tolerance_excess(more) == pytest.approx(tolerance_excess(found))
