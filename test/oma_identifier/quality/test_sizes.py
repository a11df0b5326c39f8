"""Channels far larger or smaller than the others of their kind."""

import numpy as np
import pytest

from modal_core.quality import ChannelQuality
from oma_identifier.quality import check_sizes, noise_rms

SEED = 12


def channels(values, units=None):
    noise = noise_rms(values)
    return [
        ChannelQuality(f'c{n}', rms=float(signal.std()), noise_rms=float(noise[n]),
                       unit=units[n] if units else 'm/s^2')
        for n, signal in enumerate(values.T)
    ]  # fmt: skip


@pytest.fixture
def values():
    time_s = np.arange(6000) / 200.0
    rng = np.random.default_rng(SEED)
    tones = np.sin(2.0 * np.pi * np.outer(time_s, [5.1, 8.3, 13.7]) + rng.uniform(0, 6, 3))
    return tones @ rng.uniform(0.3, 1.0, (3, 5)) + 0.01 * rng.standard_normal((6000, 5))


def test_a_channel_in_a_thousandth_of_the_unit_is_told(values):
    assert not check_sizes(channels(values))
    values[:, 3] *= 1e-3
    assert check_sizes(channels(values)) == {'c3': 'small_suspicion'}


def test_a_channel_in_a_thousand_times_the_unit_is_told(values):
    values[:, 3] *= 1e3
    assert check_sizes(channels(values)) == {'c3': 'large_suspicion'}


def test_noise_other_kinds_and_too_few_channels_raise_no_suspicion(values):
    silent = values.copy()
    silent[:, 3] = 1e-4 * np.random.default_rng(SEED).standard_normal(6000)
    assert not check_sizes(channels(silent))
    values[:, 3] *= 1e-3
    assert not check_sizes(channels(values, ['m/s^2'] * 3 + ['m/s'] * 2))
    assert not check_sizes(channels(values[:, 2:4]))
