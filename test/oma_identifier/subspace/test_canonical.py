"""Canonical variates against their definition and against finite differences."""

import numpy as np
import pytest
from scipy.linalg import solve_triangular, toeplitz

from oma_identifier.covariance.output_covariance import CovarianceAccumulator
from oma_identifier.subspace.canonical import factorise_canonical
from oma_identifier.subspace.ssi_cov import block_hankel, HankelFactors, MultiOrder
from oma_identifier.subspace.uncertainty import PoleSensitivity

ROWS = 10


@pytest.fixture(scope='module')
def blocks(structure):
    samples = structure((5.0, 12.0, 12.4), (0.02, 0.02, 0.01), n_channels=4).simulate(
        np.random.default_rng(43), 60.0, 64.0
    )
    accumulator = CovarianceAccumulator(2 * ROWS - 1, np.arange(4), 60, 64)
    accumulator.add(samples.acceleration / samples.acceleration.std(axis=0))
    return accumulator


@pytest.fixture(scope='module')
def factors(blocks):
    return factorise_canonical(blocks.mean, blocks.at_once, ROWS)


def test_covariance_at_once_is_that_of_the_samples(blocks):
    assert np.diag(blocks.at_once) == pytest.approx(blocks.power)
    assert blocks.at_once == pytest.approx(blocks.at_once.T)


def test_future_and_past_are_white(blocks, factors):
    """One channel alone: its Toeplitz matrix stands in both roots."""
    first = toeplitz([blocks.at_once[0, 0], *blocks.mean[: ROWS - 1, 0, 0]])
    for root in (factors.left_root, factors.right_root):
        own = (root @ root.T)[::4, ::4]
        assert own == pytest.approx(first, abs=2e-3 * first[0, 0])


def test_singular_values_are_correlations(factors):
    assert np.all(factors.values <= 1.0)
    assert factors.values[0] > 0.9


def test_basis_and_columns_are_of_the_hankel_matrix(blocks, factors):
    hankel = block_hankel(blocks.mean, ROWS)
    assert hankel @ factors.columns == pytest.approx(factors.observability, abs=1e-6)


@pytest.mark.parametrize('order', [6, 12])
def test_gradient_is_the_derivative(blocks, factors, order):
    direction = np.random.default_rng(44).standard_normal(blocks.mean.shape)
    step = 1e-8 * np.abs(blocks.mean).max()
    system = MultiOrder(factors, order)
    solution = system.solve(order)
    # What makes past and future white is taken for known.
    hankel = block_hankel(blocks.mean + step * direction, ROWS)
    white = solve_triangular(factors.left_root, hankel, lower=True)
    white = solve_triangular(factors.right_root, white.T, lower=True).T
    left, values, right = np.linalg.svd(white)
    after = HankelFactors(left, values, right.T, 4, 4, factors.left_root, factors.right_root)
    moved = MultiOrder(after, order).solve(order).eigenvalue
    upper = solution.eigenvalue[solution.eigenvalue.imag > 0.0]
    gradients = PoleSensitivity(system).gradients([solution] * len(upper), upper)
    predicted = step * np.array([np.sum(each * direction) for each in gradients])
    found = np.array([moved[np.argmin(np.abs(moved - value))] - value for value in upper])
    # Three modes: the others follow the noise, and answer to it far from linearly.
    surest = np.argsort(np.abs(predicted))[:3]
    assert found[surest] == pytest.approx(predicted[surest], rel=0.03, abs=1e-3 * step)
