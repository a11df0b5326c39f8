"""Modes that ring for as long as the record are modes, lines are lines, and doubt is said."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from modal_core.numbers.indicators import mac
from oma_identifier.identify import identify_samples
from oma_identifier.spectra.line_or_mode import odds_of
from oma_identifier.spectra.thresholds import SPECTRA

SEED = 4100
N_SEGMENTS, FINE = 32, 24


def phasors(rng, decays, noise):
    """Return those of a mode with so many decay times in the record, or of a line, in noise."""
    n = N_SEGMENTS * FINE
    moved = np.ones(n, dtype=complex)
    if decays is not None:
        kept = np.exp(-decays / n)
        force = (rng.standard_normal(n) + 1j * rng.standard_normal(n)) / np.sqrt(2.0)
        force[1:] *= np.sqrt(1.0 - kept**2)
        moved = lfilter([1.0], [1.0, -kept], force)
    taper = np.blackman(FINE + 2)[1:-1]
    moved = moved.reshape(N_SEGMENTS, FINE) @ taper / taper.sum()
    white = rng.standard_normal(N_SEGMENTS) + 1j * rng.standard_normal(N_SEGMENTS)
    return moved + noise * white / np.sqrt(2.0)


@pytest.mark.parametrize('noise', [0.003, 0.05])
def test_odds_tell_a_line_from_a_mode_that_hardly_decays(noise):
    """A line is sure in 97 of a hundred, and of a hundred modes one may look like a sure line."""
    rng = np.random.default_rng(SEED)
    decays = rng.uniform(0.3, 6.0, 100)
    modes = np.array([odds_of(phasors(rng, each, noise), 0.2).line for each in decays])
    lines = np.array([odds_of(phasors(rng, None, noise), 0.2).line for _ in range(100)])
    assert np.mean(modes > SPECTRA.sure_line) <= 0.02, f'seed {SEED}'
    assert np.mean(modes > 0.0) <= 0.06, f'seed {SEED}'
    assert np.mean(lines > SPECTRA.sure_line) >= 0.95, f'seed {SEED}'


def test_modes_of_light_damping_are_neither_lost_nor_called_lines(structure):
    """Their ζfT in 60 s is 0.3 to 4; shapes tell the two that are six spectral lines apart."""
    hz, ratio = (5.3, 8.7, 8.8, 14.1, 22.5, 30.4), (0.001, 0.002, 0.0015, 0.001, 0.003, 0.002)
    known = structure(hz, ratio, n_channels=10)
    n_found = n_extra = n_lines = 0
    seeds = range(SEED, SEED + 8)
    for seed in seeds:
        found = identify_samples(known.simulate(np.random.default_rng(seed), 60.0, 100.0, 0.02))
        for mode, shape in zip(hz, known.shapes.T, strict=True):
            near = np.abs(found.modes.frequency_hz / mode - 1.0) < 0.005
            alike = mac(found.modes.shapes, shape[:, None])[:, 0] > 0.8
            n_found += bool((near & alike).any())
        n_extra += max(0, len(found.modes) - len(hz))
        n_lines += len(found.harmonics)
        # None is there: what is taken for one is said to be in doubt.
        assert ('line_or_mode' in found.quality.flags) == (len(found.harmonics) > 0)
    assert n_found >= 0.9 * len(hz) * len(seeds), f'seeds {seeds}: {n_found}'
    assert n_extra == 0, f'seeds {seeds}'
    assert n_lines <= 2, f'seeds {seeds}'


def test_lines_beside_modes_are_no_modes(structure):
    """One in a few half-widths of a mode of another shape, one by itself, constant or wavering."""
    known = structure((7.29, 21.0), (0.022, 0.01), n_channels=6)
    seeds = range(SEED, SEED + 8)
    for seed in seeds:
        rng = np.random.default_rng(seed)
        clean = known.simulate(rng, 40.0, 100.0)
        time = np.arange(len(clean.acceleration)) / 100.0
        waver = 0.2 * np.sin(2.0 * np.pi * 0.05 * time) * (seed % 2)
        lines = np.sin(2.0 * np.pi * np.outer(time, (7.09, 13.3)) + waver[:, None])
        lines = lines @ rng.standard_normal((2, 6)) * clean.acceleration.std()
        found = identify_samples(replace(clean, acceleration=clean.acceleration + lines))
        for line in (7.09, 13.3):
            near = np.abs(found.modes.frequency_hz - line) < 0.05
            assert not near.any(), f'seed {seed}: {found.modes.frequency_hz}'
            assert np.any(np.abs(found.harmonics.frequency_hz - line) < 0.05), f'seed {seed}'
