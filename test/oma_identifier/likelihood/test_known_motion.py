"""Known inputs in the likelihood of a band: derivatives, and what the inputs take from it."""

import numpy as np

from oma_identifier.likelihood.band_model import accelerance, BandData, BandModel
from oma_identifier.likelihood.fit_band import mean_at
from oma_identifier.likelihood.force_prior import Prior
from oma_identifier.likelihood.known_motion import averages_with, principal_inputs
from oma_identifier.likelihood.scoring_step import moved
from oma_identifier.likelihood.whittle import downhill_gradient, evaluate

SEED = 47
N_LINES, N_CHANNELS, N_INPUTS = 240, 4, 2


def drawn(seed, driven):
    """Return a band with two modes, inputs and, where ``driven``, what these do."""
    rng = np.random.default_rng(seed)

    def normal(*shape):
        return (rng.standard_normal(shape) + 1j * rng.standard_normal(shape)) / np.sqrt(2.0)

    hz = np.linspace(8.0, 12.0, N_LINES)
    shapes = np.linalg.qr(rng.standard_normal((N_CHANNELS, 2)))[0].astype(complex)
    model = BandModel(
        np.array([9.4, 10.3]),
        np.array([0.02, 0.015]),
        shapes,
        np.eye(2, dtype=complex),
        np.full(N_CHANNELS, 3.0),
        2,
        reference_hz=10.0,
    )
    gain = accelerance(hz, model.frequency_hz, model.damping_ratio)
    inputs = principal_inputs(normal(N_INPUTS, N_LINES), 2, N_CHANNELS)
    force = normal(N_LINES, 2) + driven * 5.0 * inputs.T @ normal(N_INPUTS, 2)
    values = (gain * force) @ shapes.T + driven * inputs.T @ normal(N_INPUTS, N_CHANNELS)
    values += np.sqrt(3.0) * normal(N_LINES, N_CHANNELS)
    products = values[:, :, None] * values[:, None, :].conj()
    data = BandData(hz, products, np.ones(N_LINES), np.zeros(N_LINES))
    return averages_with(data, values, inputs), model


def test_gradient_is_that_of_the_value():
    data, model = drawn(SEED, driven=1.0)
    prior = Prior.of(model)
    at = evaluate(data, model, prior)
    downhill = downhill_gradient(data, model, prior, at)
    for place in range(len(downhill)):
        step = np.zeros(len(downhill))
        values = []
        for sign in (1.0, -1.0):
            step[place] = sign * 1e-5
            values.append(evaluate(data, moved(model, step), prior).value)
        slope = (values[1] - values[0]) / 2e-5
        tolerance = 1e-4 * np.abs(downhill).max() + 1e-3 * abs(slope)
        assert abs(downhill[place] - slope) < tolerance, f'seed {SEED}, parameter {place}'


def test_inputs_explain_what_they_drive_and_no_more_than_chance_otherwise():
    data, model = drawn(SEED, driven=1.0)
    assert mean_at(data, model).chance < 1e-12
    chances = [mean_at(*drawn(seed, driven=0.0)).chance for seed in range(SEED + 1, SEED + 101)]
    assert np.mean(chances) == np.clip(np.mean(chances), 0.4, 0.6), f'seeds from {SEED + 1}'
    assert np.mean(np.array(chances) < 0.05) < 0.13, f'seeds from {SEED + 1}'
