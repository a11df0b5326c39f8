"""Output covariances against their definition, also after a blow just before the record."""

import numpy as np
import pytest

from modal_core.channel import Channel
from modal_core.samples import Samples
from oma_identifier.covariance.output_covariance import CovarianceAccumulator, WhenFull
from oma_identifier.identify import identify_samples
from oma_identifier.settings import IdentificationSettings

N_LAGS, BLOCK = 12, 40


def products(rows: np.ndarray, lag: int) -> np.ndarray:
    return rows[lag:].T @ rows[: len(rows) - lag]


def accumulated(stretches, when_full=WhenFull.JOIN, capacity=8) -> CovarianceAccumulator:
    found = CovarianceAccumulator(N_LAGS, np.arange(2), BLOCK, capacity, when_full)
    for rows in stretches:
        found.interrupt()
        found.add(rows)
    return found


@pytest.mark.parametrize('n_blocks', [(3,), (5,), (16,), (3, 2), (7, 9)])
def test_sums_are_divided_by_the_products_there_are(n_blocks):
    rng = np.random.default_rng(len(n_blocks))
    stretches = [rng.standard_normal((BLOCK * n, 2)) + 1.0 for n in n_blocks]
    found = accumulated(stretches)
    result = found.result(1.0)
    for lag in range(1, N_LAGS + 1):
        count = sum(len(rows) - lag for rows in stretches)
        exact = sum(products(rows, lag) for rows in stretches) / count
        np.testing.assert_allclose(found.mean[lag - 1], exact, atol=2e-6)
        np.testing.assert_allclose(result.mean[lag - 1], exact, atol=2e-6)


def test_a_window_that_has_left_the_beginning_behind_lacks_no_products():
    rows = np.random.default_rng(3).standard_normal((BLOCK * 20, 2))
    found = accumulated([rows], WhenFull.RETIRE)
    kept = np.arange(BLOCK * 12, BLOCK * 20)
    for lag in range(1, N_LAGS + 1):
        exact = rows[kept].T @ rows[kept - lag] / len(kept)
        np.testing.assert_allclose(found.mean[lag - 1], exact, atol=2e-6)


def test_a_decay_at_the_beginning_falls_as_fast_as_it_does():
    time = np.arange(BLOCK * 8)
    rows = np.exp(-0.1 * time)[:, None] * np.ones(2)
    mean = accumulated([rows]).mean[:, 0, 0]
    counts = len(rows) - np.arange(1, N_LAGS + 1)
    rates = -np.diff(np.log(mean * counts))
    np.testing.assert_allclose(rates, 0.1, rtol=1e-4)


def test_a_blow_just_before_the_record_does_not_bias_damping(structure):
    hz, zeta, rate_hz = 12.5, 0.016, 64.0
    known = structure((8.0, hz, 19.0), (0.02, zeta, 0.02))
    found = []
    for seed in range(6):
        samples = known.simulate(np.random.default_rng(seed), 120.0, rate_hz)
        time = np.arange(len(samples.acceleration)) / rate_hz
        pole = 2.0 * np.pi * hz * (1j * np.sqrt(1.0 - zeta**2) - zeta)
        decay = 40.0 * np.exp(pole * time).real[:, None] * known.shapes[:, 1]
        names = tuple(Channel(name=name) for name in samples.channel_names)
        blown = Samples(samples.acceleration + decay, rate_hz, names)
        modes = identify_samples(blown, IdentificationSettings(refine=False)).modes
        near = min(modes, key=lambda mode: abs(mode.frequency_hz - hz))
        found.append(near.damping_ratio)
    # Scaled by the products of its first block alone it came out as 0.0103.
    assert np.mean(found) == pytest.approx(zeta, rel=0.05)
