"""A tolerance that fitted poses are explained by must do as much in the held-out ones."""

import numpy as np
import pytest
from scipy.stats import kstest

from model_gap.fit.heldout_chance import chance, error_of

TOLERANCES, ROWS = 12, 400


def arm(rng, weight, wrong=0.0, rows=ROWS):
    """Return a residual in held-out rows, their derivatives and the fit's error, all linear.

    Of the tolerances half are told by the fitted rows; ``wrong`` moves these with one of them.
    """
    told = np.r_[np.full(TOLERANCES // 2, 1.0), np.full(TOLERANCES // 2, 0.01)]
    fitted, heldout = (told * rng.standard_normal((rows, TOLERANCES)) for _ in range(2))
    heldout[:, TOLERANCES // 2 :] *= 50.0
    truth = rng.standard_normal(TOLERANCES)
    noise = [np.sqrt(0.5) * rng.standard_normal(rows) for _ in range(2)]
    moved = truth + wrong * np.eye(TOLERANCES)[0]
    hessian = weight * fitted.T @ fitted + np.eye(TOLERANCES)
    found = np.linalg.solve(hessian, weight * fitted.T @ (fitted @ moved + noise[0]))
    residual = heldout @ (truth - found) + noise[1]
    return residual, heldout.T, error_of(fitted.T @ fitted, weight)


@pytest.mark.parametrize('weight', [0.05, 2.0])
def test_chance_is_even_where_nothing_is_wrong_however_the_data_are_weighted(weight):
    rng = np.random.default_rng(31)
    found = [chance(*arm(rng, weight)) for _ in range(300)]
    assert kstest(found, 'uniform').pvalue > 0.01


def test_what_only_the_fitted_rows_call_for_is_noticed():
    """0.1² by the noise of ½: 2 % of its power, along one tolerance of twelve."""
    rng = np.random.default_rng(32)
    found = [chance(*arm(rng, 0.05, wrong=0.1, rows=10 * ROWS)) for _ in range(50)]
    assert np.mean(np.array(found) < 1e-3) > 0.8
