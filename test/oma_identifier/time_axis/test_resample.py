"""Accuracy of the reconstruction over frequency, against signals known at every instant."""

import numpy as np
import pytest

from oma_identifier.time_axis.resample import fill_gaps, interpolate, remove_jitter

N = 2000
INSIDE = slice(200, -200)


def tone(share_of_nyquist, steps):
    return np.sin(np.pi * share_of_nyquist * steps + 0.3)[:, None]


@pytest.mark.parametrize('share, limit', [(0.04, 1e-4), (0.4, 1e-4), (0.8, 1e-4), (0.86, 1e-4)])
def test_interpolation_error_over_frequency(share, limit):
    positions = np.arange(300, 1500) + np.linspace(0.0, 1.0, 1200)
    found = interpolate(tone(share, np.arange(N)), positions)
    assert np.abs(found - tone(share, positions)).max() < limit


@pytest.mark.parametrize('share, limit', [(0.04, 1e-4), (0.4, 1e-4), (0.8, 1e-4), (0.86, 1e-4)])
def test_five_percent_jitter_is_removed(share, limit):
    seed = 1
    offsets = np.random.default_rng(seed).normal(0.0, 0.05, N).clip(-0.2, 0.2)
    measured = tone(share, np.arange(N) + offsets)
    truth = tone(share, np.arange(N))[INSIDE]
    found = remove_jitter(measured, offsets)[INSIDE]
    untouched = np.sqrt(np.mean((measured[INSIDE] - truth) ** 2))
    error = np.sqrt(np.mean((found - truth) ** 2))
    assert error < limit, f'seed {seed}'
    assert untouched > 20.0 * error


def test_a_slower_grid_is_free_of_aliases():
    # 0.9 of the input's Nyquist frequency would fold onto 0.2 of a grid half as fast.
    fast = tone(0.9, np.arange(N))
    found = interpolate(fast, np.arange(200, 1800, 2.0), cutoff=0.5)
    assert np.abs(found).max() < 1e-3


def test_gaps_in_a_ringing_signal_are_filled():
    seed = 4
    rng = np.random.default_rng(seed)
    steps = np.arange(N)
    signal = tone(0.05, steps) + 0.5 * tone(0.33, steps) + 1e-3 * rng.normal(size=(N, 1))
    missing = np.zeros(N, dtype=bool)
    for start in range(100, 1900, 90):
        missing[start : start + 5] = True
    holed = np.where(missing[:, None], 1e9, signal)
    error = fill_gaps(holed, missing)[missing] - signal[missing]
    assert np.sqrt(np.mean(error**2)) < 0.02, f'seed {seed}'
