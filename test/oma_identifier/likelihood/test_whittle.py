"""The Whittle likelihood of a band: its derivatives, and fits from awkward starts."""

from dataclasses import replace

import numpy as np
import pytest

from oma_identifier.likelihood import scoring_step, whittle, whittle_information
from oma_identifier.likelihood.band_model import accelerance, BandData, BandModel, with_root
from oma_identifier.likelihood.fit_band import fit_band
from oma_identifier.likelihood.force_prior import Prior

N_LINES, N_CHANNELS = 60, 4
STEP = 1e-6


def band(seed: int, n_free: int, n_forces: int) -> tuple[BandData, BandModel]:
    """Return averaged periodograms that some other model could have made, and a model."""
    generator = np.random.default_rng(seed)
    n_modes = 3
    shapes = generator.standard_normal((N_CHANNELS, n_modes, 2)) @ (1.0, 0.3j)
    mixing = generator.standard_normal((n_modes, n_modes, 2)) @ (1.0, 1.0j)
    model = BandModel(
        frequency_hz=np.array([9.0, 10.1, 12.0]),
        damping_ratio=np.array([0.02, 0.03, 0.015]),
        shapes=shapes / np.linalg.norm(shapes, axis=0),
        force=mixing @ mixing.conj().T / 300.0 + 0.01 * np.eye(n_modes),
        noise=generator.uniform(0.1, 0.5, N_CHANNELS),
        n_free=n_free,
        reference_hz=10.0,
        slope=0.4,
        curvature=-0.7,
    )
    if n_forces:
        model = with_root(model, mixing[:, :n_forces] / 10.0)
    rows = generator.standard_normal((N_LINES, 6, N_CHANNELS, 2)) @ (0.7, 0.7j)
    return (
        BandData(
            np.linspace(7.0, 14.0, N_LINES),
            np.einsum('kni,knj->kij', rows, rows.conj()) / 6.0,
            generator.integers(1, 9, N_LINES).astype(float),
        ),
        model,
    )


def covariance(data: BandData, model: BandModel) -> np.ndarray:
    gain = accelerance(data.frequency_hz, model.frequency_hz, model.damping_ratio)
    x = np.log(data.frequency_hz / model.reference_hz)
    gain *= np.exp(0.5 * (model.slope * x + 0.5 * model.curvature * x**2))[:, None]
    amplitude = model.shapes * gain[:, None]
    return amplitude @ model.force @ amplitude.conj().transpose(0, 2, 1) + np.diag(model.noise)


CASES = [(3, 0), (2, 0), (1, 0), (2, 2), (2, 1)]


@pytest.mark.parametrize(('n_free', 'n_forces'), CASES)
def test_information_is_that_of_the_derivatives_of_the_covariance(n_free, n_forces, monkeypatch):
    monkeypatch.setattr(scoring_step, 'ALIKE', 0.0)
    data, model = band(3, n_free, n_forces)
    prior = Prior.of(model)
    at = whittle.evaluate(data, model, prior)
    found = whittle_information.information(whittle.evaluated_at(data, model, at))
    precision = np.linalg.inv(covariance(data, model))
    derivatives = []
    for row in np.eye(len(found)):
        up, down = (scoring_step.moved(model, sign * STEP * row) for sign in (1.0, -1.0))
        change = (covariance(data, up) - covariance(data, down)) / (2.0 * STEP)
        derivatives.append(precision @ change)
    stacked = np.array(derivatives)
    expected = np.einsum('k,akij,bkji->ab', data.n_averaged, stacked, stacked).real
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    assert np.abs(found - expected).max() < 1e-6 * np.diag(expected).max()
    assert np.abs((found - expected) / scale).max() < 1e-6


@pytest.mark.parametrize(('n_free', 'n_forces'), CASES)
def test_gradient_is_that_of_the_likelihood_and_its_priors(n_free, n_forces):
    data, model = band(4, n_free, n_forces)
    # Away from the centre of the priors, so that they pull.
    prior = Prior.of(replace(model, force=1.1 * model.force, noise=1.2 * model.noise))
    at = whittle.evaluate(data, model, prior)
    downhill = whittle.downhill_gradient(data, model, prior, at)
    for row, expected in zip(np.eye(len(downhill)), downhill, strict=True):
        up, down = (
            whittle.evaluate(data, scoring_step.moved(model, sign * STEP * row), prior).value
            for sign in (1.0, -1.0)
        )
        assert (down - up) / (2.0 * STEP) == pytest.approx(expected, rel=1e-5, abs=1e-3)


def one_mode_and_a_tail(seed: int, tail_hz: float) -> tuple[BandData, BandModel]:
    """Return 40 averaged periodograms of two channels, and the model that made them."""
    generator = np.random.default_rng(seed)
    frequency = np.linspace(9.0, 11.0, 60)
    shapes = np.array([[1.0, 0.0], [0.5, 1.0]]) + 0j
    model = BandModel(
        np.array([10.0, tail_hz]),
        np.array([0.02, 0.02]),
        shapes / np.linalg.norm(shapes, axis=0),
        np.eye(2) + 0j,
        np.full(2, 0.3),
        1,
        reference_hz=10.0,
    )
    gain = accelerance(frequency, model.frequency_hz, model.damping_ratio)
    white = generator.standard_normal((4, 40, 60, 2)) / np.sqrt(2.0)
    values = ((white[0] + 1j * white[1]) * gain) @ model.shapes.T
    values += np.sqrt(0.3) * (white[2] + 1j * white[3])
    periodogram = np.mean(values[..., :, None] * values[..., None, :].conj(), axis=0)
    return BandData(frequency, periodogram, np.full(60, 40.0)), model


def test_a_fit_begins_where_forces_of_an_earlier_pass_are_no_covariance():
    """A band determines forces of far tails badly; beside other shapes they may go below zero."""
    data, model = one_mode_and_a_tail(seed=7, tail_hz=15.0)
    near = replace(model, force=np.diag([1.0, -8.0]).astype(complex))
    found = fit_band(data, model, near=near)
    assert found.converged
    assert abs(found.model.frequency_hz[0] - 10.0) < 4.0 * found.frequency_std[0] * 10.0


def test_a_fit_does_not_run_away_where_a_tail_starts_with_a_force_below_zero():
    data, model = one_mode_and_a_tail(seed=11, tail_hz=100.0)
    found = fit_band(data, replace(model, force=np.diag([1.0, -0.02]).astype(complex)))
    assert found.converged and found.misfit < 1.3
    assert np.all(np.abs(np.log(found.model.noise / 0.3)) < 0.3)
