"""Measured beside predicted: every figure with an uncertainty that holds."""

import numpy as np
import pytest

from model_gap.comparison.harmonics import over
from model_gap.comparison.transmissibility import ratio

SEED = 12


def test_ratio_comes_back_within_its_uncertainty():
    """Many drawings of a known gain and phase under noise: two sigma hold in about 95 %."""
    rng = np.random.default_rng(SEED)
    gain, phase, noise, count = 0.8, 0.3, 0.5, 300
    inside, draws = 0, 200
    for _ in range(draws):
        predicted = rng.standard_normal((count, 2)) @ [1.0, 1j]
        spoilt = noise * (rng.standard_normal((count, 2)) @ [1.0, 1j])
        found = ratio(gain * np.exp(1j * phase) * predicted + spoilt, predicted)
        near = abs(found.magnitude - gain) < 2.0 * found.magnitude_sigma
        inside += near and abs(found.phase_rad - phase) < 2.0 * found.phase_sigma_rad
        expected = gain**2 / (gain**2 + noise**2)
        assert found.coherence == pytest.approx(expected, abs=0.12)
    assert inside > 0.9 * draws, f'seed {SEED}: {inside} of {draws}'


def test_noise_of_the_prediction_counts_as_uncertainty():
    """Noise on the known motion makes the magnitude too small; the deviation says by how much."""
    rng = np.random.default_rng(SEED)
    true = rng.standard_normal((4000, 2)) @ [1.0, 1j]
    spoilt = true + 0.5 * (rng.standard_normal((4000, 2)) @ [1.0, 1j])
    power = float(np.sum(np.abs(spoilt - true) ** 2))
    blind, told = ratio(true, spoilt), ratio(true, spoilt, power)
    assert abs(blind.magnitude - 1.0) > 5.0 * blind.magnitude_sigma
    assert abs(told.magnitude - 1.0) < 1.5 * told.magnitude_sigma


def test_nothing_measured_has_no_ratio():
    found = ratio(np.zeros(5, dtype=complex), np.ones(5, dtype=complex))
    assert found.coherence == 0.0
    assert found.magnitude_sigma == float('inf')


def test_nothing_over_nothing_is_no_line():
    line, around = np.array([0.0, 0.0, 3.0, 8.0]), np.array([0.0, 2.0, 0.0, 2.0])
    with np.errstate(all='raise'):
        found = over(line, around)
    np.testing.assert_allclose(10.0 * np.log10(found), [0.0, -120.0, 120.0, 10.0 * np.log10(4.0)])
