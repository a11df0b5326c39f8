"""Standard deviations against finite differences and against the scatter of many runs."""

import numpy as np
import pytest

from oma_identifier.compare.comparison import compare_modes
from oma_identifier.covariance.output_covariance import CovarianceAccumulator
from oma_identifier.identify import identify_samples
from oma_identifier.settings import IdentificationSettings
from oma_identifier.subspace.ssi_cov import block_hankel, factorise, MultiOrder
from oma_identifier.subspace.uncertainty import deviation_of_mean, PoleSensitivity


@pytest.fixture
def covariance(structure):
    samples = structure((5.0, 12.0, 12.4), (0.02, 0.02, 0.01)).simulate(
        np.random.default_rng(40), 60.0, 64.0
    )
    accumulator = CovarianceAccumulator(19, np.arange(6), 60, 64)
    accumulator.add(samples.acceleration)
    return accumulator.result(64.0)


def test_block_hankel_places_lags_on_antidiagonals():
    covariance = np.arange(5 * 2 * 3).reshape(5, 2, 3).astype(float)
    hankel = block_hankel(covariance, 3)
    assert hankel.shape == (6, 9)
    for row in range(3):
        for column in range(3):
            block = hankel[2 * row : 2 * row + 2, 3 * column : 3 * column + 3]
            np.testing.assert_array_equal(block, covariance[row + column])


def test_singular_triplets_rebuild_the_hankel_matrix(covariance):
    factors = factorise(covariance.mean, 10)
    hankel = block_hankel(covariance.mean, 10)
    rebuilt = factors.left * factors.values @ factors.right.T
    np.testing.assert_allclose(rebuilt, hankel, atol=1e-6 * np.abs(hankel).max())


@pytest.mark.parametrize('order', [8, 16])
def test_gradient_is_the_derivative(covariance, order):
    direction = np.random.default_rng(41).standard_normal(covariance.mean.shape)
    step = 1e-7 * np.abs(covariance.mean).max()
    system = MultiOrder(factorise(covariance.mean, 10), order)
    solution = system.solve(order)
    moved = MultiOrder(factorise(covariance.mean + step * direction, 10), order).solve(order)
    upper = solution.eigenvalue[solution.eigenvalue.imag > 0.0]
    assert len(upper) >= 3
    gradients = PoleSensitivity(system).gradients([solution] * len(upper), upper)
    for value, gradient in zip(upper, gradients, strict=True):
        nearest = moved.eigenvalue[np.argmin(np.abs(moved.eigenvalue - value))]
        predicted = step * np.sum(gradient * direction)
        # The gradient is kept in single precision, the difference has a second-order error.
        assert abs(nearest - value - predicted) < 0.01 * abs(predicted)


def test_deviation_of_a_correlated_mean():
    rng = np.random.default_rng(42)
    inside = []
    for _ in range(2000):
        noise = rng.standard_normal(66)
        series = noise[2:] + 0.8 * noise[1:-1] + 0.3 * noise[:-2]
        inside.append(abs(series.mean()) < 2.0 * deviation_of_mean(series, 16))
    assert 0.935 < np.mean(inside) < 0.975


def test_two_standard_deviations_hold_the_truth(structure):
    frequency, damping = np.array([6.0, 11.0, 11.5]), np.array([0.03, 0.012, 0.02])
    known = structure(frequency, damping)
    settings = IdentificationSettings(refine=False, min_frequency_hz=4.0, max_order=24)
    inside, scatter, n_missed = [], [], 0
    for seed in range(60):
        modes = identify_samples(
            known.simulate(np.random.default_rng(4000 + seed), 60.0, 64.0), settings
        ).modes
        for hz, zeta in zip(frequency, damping, strict=True):
            mode = min(modes, key=lambda mode, hz=hz: abs(mode.frequency_hz - hz))
            if abs(mode.frequency_hz - hz) > 0.25:
                n_missed += 1
                continue
            f_error = (mode.frequency_hz - hz) / mode.frequency_std_hz
            d_error = (mode.damping_ratio - zeta) / mode.damping_ratio_std
            inside += [abs(f_error) < 2.0, abs(d_error) < 2.0]
            scatter.append((mode.frequency_hz / hz - 1.0) / np.sqrt(zeta / (2 * np.pi * hz * 60)))
    # One of the close pair cannot always be told from its neighbour at 24 orders: of 540 modes at
    # other seeds 4 were missed; of 180, more than four would be once in 100 times.
    assert n_missed <= 4, n_missed
    # 360 draws: 95 % ± 2.5 standard deviations of a proportion.
    assert 0.92 < np.mean(inside) < 0.98, np.mean(inside)
    assert np.sqrt(np.mean(np.square(scatter))) < 2.0


def test_a_change_is_told_from_scatter(structure):
    settings = IdentificationSettings(refine=False)
    at_rest = structure((6.0, 11.0, 20.0), (0.02, 0.015, 0.02))
    running = structure((6.0, 11.6, 25.0), (0.02, 0.015, 0.02))
    first = identify_samples(
        at_rest.simulate(np.random.default_rng(43), 120.0, 64.0), settings
    ).modes
    second = identify_samples(
        running.simulate(np.random.default_rng(44), 120.0, 64.0), settings
    ).modes
    comparison = compare_modes(first, second)
    assert [change.is_significant for change in comparison.changes] == [False, True, True]
    assert comparison.changes[1].frequency_change == pytest.approx(0.6 / 11.0, rel=0.1)
    assert not comparison.only_first and not comparison.only_second
