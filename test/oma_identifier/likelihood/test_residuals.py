"""What modes that nobody found do in a band, under few forces, is no part of the mode there."""

import numpy as np
from scipy.stats import chi2

from modal_core.channel import Channel
from modal_core.samples import Samples
from oma_identifier.likelihood import (
    fit_with_residuals,
    ModeIndex,
    spectra_of,
    StartModes,
    unit,
)
from oma_identifier.refinement import REFINEMENT

RATE_HZ, DURATION_S, N_CHANNELS, N_FORCES = 100.0, 200.0, 6, 2
FREQUENCY_HZ = np.array([20.0, 38.0, 43.0, 47.0])
DAMPING = np.array([0.03, 0.05, 0.05, 0.05])


def responses(rng: np.random.Generator, shapes: np.ndarray) -> Samples:
    """Return the responses of all modes to few white forces that repeat."""
    n = round(DURATION_S * RATE_HZ)
    s = 2j * np.pi * np.fft.fftfreq(n, 1.0 / RATE_HZ)[:, None]
    omega = 2.0 * np.pi * FREQUENCY_HZ
    gain = s**2 / (s**2 + 2.0 * DAMPING * omega * s + omega**2)
    force = rng.standard_normal((n, N_FORCES)) @ rng.standard_normal((N_FORCES, len(omega)))
    clean = np.fft.ifft(gain * np.fft.fft(force, axis=0), axis=0).real @ shapes.T
    clean += 0.01 * clean.std() * rng.standard_normal(clean.shape)
    return Samples(clean, RATE_HZ, tuple(Channel(f's{i}') for i in range(N_CHANNELS)))


def errors(seed: int) -> tuple[float, float, float]:
    """Return errors of frequency and damping over their deviations, and the misfit."""
    rng = np.random.default_rng(seed)
    shapes = rng.standard_normal((N_CHANNELS, len(FREQUENCY_HZ)))
    samples = responses(rng, shapes)
    start = StartModes(
        1.005 * FREQUENCY_HZ[:1], 1.1 * DAMPING[:1], unit(shapes[:, 0] + 0j)[:, None]
    )
    spectra = spectra_of(samples, np.arange(N_CHANNELS))
    usable = np.ones(len(spectra.frequency_hz), dtype=bool)
    found = fit_with_residuals(spectra, start, [ModeIndex(0)], usable)
    model = found.fit.model
    return (
        np.log(model.frequency_hz[0] / FREQUENCY_HZ[0]) / found.fit.frequency_std[0],
        np.log(model.damping_ratio[0] / DAMPING[0]) / found.fit.damping_ratio_std[0],
        found.misfit,
    )


def test_a_mode_beside_some_that_nobody_found_has_its_own_frequency_and_damping():
    seeds = range(3100, 3120)
    found = np.array([errors(seed) for seed in seeds])
    described = found[found[:, 2] < REFINEMENT.incomplete_misfit, :2]
    rms = np.sqrt(np.mean(described**2, axis=0))
    print(f'seeds {seeds}: {len(described)} described, {rms} deviations')
    # Of 100 (3100 to 3119, 3200 to 3279) 90 were; twenty show fewer once in 400 times.
    assert len(described) >= 13
    # Twenty normal errors exceed it once in 200 times.
    assert np.all(rms < np.sqrt(chi2.isf(0.005, len(described)) / len(described)))
