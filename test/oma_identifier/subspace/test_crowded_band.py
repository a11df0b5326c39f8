"""A band with more modes than the model orders hold is given twice the order."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from modal_core.channel import Channel
from modal_core.samples import Samples
from oma_identifier.identify import identify_parts
from oma_identifier.identify_bands import band_sources, identify_bands
from oma_identifier.methods import method_named
from oma_identifier.settings import IdentificationSettings
from oma_identifier.spectra import line_at
from oma_identifier.subspace import RecordStreams

RATE_HZ, DURATION_S, N_CHANNELS, N_FORCES = 100.0, 400.0, 24, 16
SETTINGS = IdentificationSettings(refine=False)


def structure(seed, n_modes):
    """Frequencies, and the response to white forces, by exact frequency responses."""
    rng = np.random.default_rng(seed)
    spacing = rng.gamma(3.0, 1.0, n_modes)
    frequency_hz = 10.0 + 32.0 * np.cumsum(spacing) / spacing.sum()
    shapes = rng.normal(size=(N_CHANNELS + N_FORCES, n_modes))
    damping = np.exp(rng.uniform(np.log(0.003), np.log(0.03), n_modes))
    n_samples = round(RATE_HZ * DURATION_S)
    omega = 2.0 * np.pi * np.fft.rfftfreq(n_samples, 1.0 / RATE_HZ)[:, None]
    natural = 2.0 * np.pi * frequency_hz
    response = -(omega**2) / (natural**2 - omega**2 + 2j * damping * natural * omega)
    force = np.fft.rfft(rng.normal(size=(n_samples, N_FORCES)), axis=0)
    modal = response * (force @ shapes[N_CHANNELS:])
    clean = np.fft.irfft(modal @ shapes[:N_CHANNELS].T, n_samples, axis=0)
    noise = 0.08 * clean.std() * rng.normal(size=clean.shape)
    channels = tuple(Channel(f'c{place}') for place in range(N_CHANNELS))
    return frequency_hz, Samples(clean + noise, RATE_HZ, channels, start_ns=0)


@pytest.mark.parametrize(('n_modes', 'order'), [(6, 60), (20, 60), (36, 120), (46, 120)])
def test_only_a_crowded_band_has_twice_the_order(n_modes, order):
    _, samples = structure(991760 + n_modes, n_modes)
    highest = band_sources([samples], SETTINGS)[0]
    assert highest.max_order == order


def test_the_modes_of_a_crowded_band_are_found():
    true_hz, samples = structure(991797, 36)
    found_hz = identify_parts([samples], SETTINGS).modes.frequency_hz
    apart_hz = np.abs(true_hz[:, None] - found_hz).min(axis=1)
    assert np.count_nonzero(apart_hz < 0.005 * true_hz) >= 32
    assert len(found_hz) <= 36


@pytest.mark.parametrize('method', ['ssi_data', 'plscf', 'vmd'])
def test_other_methods_find_the_modes_of_a_crowded_band(method):
    true_hz, samples = structure(991797, 36)
    found_hz = method_named(method).identify(samples, SETTINGS).modes.frequency_hz
    apart_hz = np.abs(true_hz[:, None] - found_hz).min(axis=1)
    assert np.count_nonzero(apart_hz < 0.005 * true_hz) >= 32
    assert len(found_hz) <= 36


@pytest.mark.parametrize(('n_modes', 'order'), [(6, 60), (20, 60), (36, 120), (46, 120)])
def test_only_a_crowded_window_has_twice_the_order(n_modes, order):
    _, samples = structure(991860 + n_modes, n_modes)
    streams = RecordStreams(SETTINGS)
    length = round(SETTINGS.window_s * RATE_HZ)
    for first in (0, length // 2):
        rows, start_ns = samples.acceleration[first : first + length], round(first / RATE_HZ * 1e9)
        streams.add(replace(samples, acceleration=rows, start_ns=start_ns))
        assert streams.results()[0].max_order == order


def test_the_modes_of_a_crowded_window_that_slides_are_found():
    true_hz, samples = structure(991897, 36)
    streams = RecordStreams(SETTINGS)
    length = round(SETTINGS.window_s * RATE_HZ)
    for first in (0, length // 3, length):
        rows, start_ns = samples.acceleration[first : first + length], round(first / RATE_HZ * 1e9)
        part = replace(samples, acceleration=rows, start_ns=start_ns)
        streams.add(part)
        found = identify_bands(streams.results(), part.channels, SETTINGS, partial(line_at, part))
        apart_hz = np.abs(true_hz[:, None] - found.modes.frequency_hz).min(axis=1)
        assert np.count_nonzero(apart_hz < 0.01 * true_hz) >= 29  # 15 to 20 with one order
        assert len(found.modes) <= 36
