"""Peaks of the spectrum against edges of it: a stated chance of error, and power."""

import numpy as np
import pytest
from scipy.signal import butter, firwin, lfilter, sosfilt

from modal_core.channel import Channel
from modal_core.samples import Samples
from oma_identifier.spectra.peaks import SpectralPeaks

RATE_HZ = 100.0
N_SAMPLES = 6000


def named(array):
    names = tuple(Channel(name=f'c{column}') for column in range(array.shape[1]))
    return Samples(array, RATE_HZ, names)


@pytest.mark.parametrize('cutoff_hz', [None, 20.0])
def test_noise_and_its_edge_pass_for_peaks_as_rarely_as_stated(cutoff_hz):
    rng = np.random.default_rng(1)
    chances = []
    for _ in range(200):
        noise = rng.standard_normal((N_SAMPLES, 4))
        if cutoff_hz is not None:
            noise = sosfilt(butter(8, cutoff_hz, fs=RATE_HZ, output='sos'), noise, axis=0)
            noise += 0.01 * rng.standard_normal(noise.shape)
        chances.append(SpectralPeaks(named(noise @ rng.standard_normal((4, 4)))).chance(20.0, 1.0))
    # Both flanks must be lower: the chance of that is at most the stated one.
    assert np.mean(np.array(chances) < 0.05) <= 0.05 + 2.0 * np.sqrt(0.05 * 0.95 / 200)


def test_a_resonance_is_a_peak_even_between_stronger_ones(structure):
    known = structure((17.0, 20.0, 23.0), (0.02, 0.03, 0.02), n_channels=4)
    chances = [
        SpectralPeaks(known.simulate(np.random.default_rng(seed), 60.0, RATE_HZ)).chance(20.0, 0.6)
        for seed in range(20)
    ]
    assert np.median(chances) < 1e-6
    assert max(chances) < 0.01, chances


def test_what_is_too_narrow_or_at_the_end_of_the_spectrum_is_said(structure):
    known = structure((20.0,), (0.01,), n_channels=2)
    peaks = SpectralPeaks(known.simulate(np.random.default_rng(2), 60.0, RATE_HZ))
    assert peaks.chance(20.0, 0.1) is None
    assert peaks.chance(49.0, 1.0) == 1.0


def test_a_falling_spectrum_is_an_edge_and_a_resonance_is_none(structure):
    rng = np.random.default_rng(3)
    edges, resonances = [], []
    known = structure((12.0, 20.0), (0.02, 0.04), n_channels=4)
    for seed in range(30):
        noise = sosfilt(
            butter(8, 20.0, fs=RATE_HZ, output='sos'), rng.standard_normal((6000, 4)), 0
        )
        noise += 0.01 * rng.standard_normal(noise.shape)
        edges.append(SpectralPeaks(named(noise)).is_edge(19.5, 1.0))
        samples = known.simulate(np.random.default_rng(seed), 60.0, RATE_HZ)
        resonances.append(SpectralPeaks(samples).is_edge(20.0, 0.8))
    assert np.mean(edges) > 0.8
    assert np.mean(resonances) < 0.05


def of_few_forces(seed):
    """Return the response of up to six modes to one to three forces, and where the modes are."""
    rng = np.random.default_rng(seed)
    n_modes, n_forces, n_channels = rng.integers(2, 7), rng.integers(1, 4), rng.integers(1, 9)
    natural = np.sort(rng.uniform(4.0, 35.0, n_modes))
    ratio = 10.0 ** rng.uniform(-2.0, -1.1, n_modes)
    hz = np.fft.rfftfreq(4 * N_SAMPLES, 0.25 / RATE_HZ)[:, None]
    gain = hz**2 / (natural**2 - hz**2 + 2j * ratio * natural * hz)
    force = np.fft.rfft(rng.standard_normal((4 * N_SAMPLES, n_forces)), axis=0)
    modal = gain * (force @ rng.standard_normal((n_forces, n_modes)))
    response = np.fft.irfft(modal, axis=0)[::4] @ rng.standard_normal((n_modes, n_channels))
    response += 0.02 * response.std() * rng.standard_normal(response.shape)
    return SpectralPeaks(named(response)), zip(natural, ratio * natural, strict=True)


def test_resonances_are_hardly_ever_cut_even_beside_zeros():
    seeds = range(700, 850)
    found = [peaks.is_cut(*at) for peaks, modes in map(of_few_forces, seeds) for at in modes]
    assert np.mean(found) < 0.01, (seeds, np.mean(found))


def test_what_rises_towards_a_mode_beyond_a_filter_is_cut_there(structure):
    known = structure((8.0, 23.0), (0.02, 0.03), n_channels=4)
    low_pass = firwin(201, 20.0, fs=RATE_HZ)
    for seed in range(20):
        samples = known.simulate(np.random.default_rng(seed), 120.0, RATE_HZ, noise=0.0)
        rng = np.random.default_rng([seed, 1])
        kept = lfilter(low_pass, 1.0, samples.acceleration, axis=0)
        kept += 1e-3 * kept.std() * rng.standard_normal(kept.shape)
        assert SpectralPeaks(named(kept)).is_cut(19.3, 0.8), seed
        assert not SpectralPeaks(samples).is_cut(23.0, 0.69), seed


def test_a_line_in_its_peak_does_not_cut_a_resonance(structure):
    known = structure((8.0, 23.0), (0.02, 0.03), n_channels=4)
    for seed in range(20):
        samples = known.simulate(np.random.default_rng(seed), 60.0, RATE_HZ)
        time_s = np.arange(len(samples.acceleration)) / RATE_HZ
        line = 10.0 * samples.acceleration.std() * np.sin(2.0 * np.pi * 22.8 * time_s)
        peaks = SpectralPeaks(named(samples.acceleration + line[:, None]))
        assert not peaks.is_cut(23.0, 0.69), seed


def bell(hz, ratio, force):
    """Return the response of one mode, or of something that bounces, to a force."""
    pole = np.exp(2.0 * np.pi * hz * (-ratio + 1j) / RATE_HZ)
    return lfilter([1.0], [1.0, -2.0 * pole.real, np.abs(pole) ** 2], force, axis=0)


def crossed(seed):
    """Return a structure of two modes, louder now and then, while one thing drives by it."""
    rng = np.random.default_rng(seed)
    n_rows, n_event = int(600 * RATE_HZ), int(15 * RATE_HZ)
    level = np.full(n_rows, 0.1)
    for begin in rng.integers(0, n_rows - n_event, 12):
        level[begin : begin + n_event] = rng.uniform(0.5, 2.0)
    modal = [bell(hz, 0.015, level * rng.standard_normal(n_rows)) for hz in (4.0, 7.0)]
    data = np.transpose(modal) @ rng.standard_normal((2, 4))
    bounce = bell(1.8, 0.03, rng.standard_normal(n_event))
    begin = int(rng.integers(0, n_rows - n_event))
    ridden = np.outer(bounce / bounce.std(), rng.standard_normal(4))
    data[begin : begin + n_event] += 3.0 * data.std() * ridden
    return named(data + 0.02 * data.std() * rng.standard_normal(data.shape))


def test_a_peak_of_one_loud_moment_is_told_from_modes_that_all_of_them_move():
    told, modes = [], []
    for seed in range(900_000, 900_020):
        peaks = SpectralPeaks(crossed(seed))
        if peaks.chance(1.8, 0.06) < 1e-4:
            told.append(peaks.is_of_moments(1.8, 0.06))
        modes += [peaks.is_of_moments(4.0, 0.06), peaks.is_of_moments(7.0, 0.105)]
    assert len(told) > 5, 'seeds from 900000'
    assert np.mean(told) > 0.7, told
    assert not any(modes), modes
