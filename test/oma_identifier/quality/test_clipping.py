"""Channels at a limit of their range: told as such alone, left out where it harms."""

import numpy as np
import pytest

from modal_core.measurements import SampleBlock
from modal_core.numbers.flat_tops import n_on_flat_top
from oma_identifier.intake.sample_buffer import SampleBuffer
from oma_identifier.quality.health import examine, summarise
from oma_identifier.settings import IdentificationSettings

SEED, RATE_HZ, N = 31, 256.0, 15_360
START = 1_700_000_000_000_000_000


def band(rng, low_hz, high_hz):
    """Return random vibration of rms 1 between two frequencies."""
    lines = np.fft.rfft(rng.standard_normal(N))
    hz = np.fft.rfftfreq(N, 1.0 / RATE_HZ)
    lines[(hz < low_hz) | (hz > high_hz)] = 0.0
    found = np.fft.irfft(lines, N)
    return found / found.std()


def flags_of(values):
    columns = np.column_stack([values])
    return examine(columns, summarise(columns))[0].flags


@pytest.mark.parametrize('band_hz', [(8.0, 12.0), (75.0, 85.0)])
@pytest.mark.parametrize('level', [0.8, 1.5, 2.2])
def test_a_clipped_channel_is_found_however_fast_it_vibrates(band_hz, level):
    """At 80 Hz of 256 hardly two samples in a row are at the limit."""
    values = band(np.random.default_rng(SEED), *band_hz)
    assert 'clipping' in flags_of(np.clip(values, -level, level)), f'seed {SEED}'
    assert 'clipping' in flags_of(np.minimum(values, level)), f'seed {SEED}'


def test_few_clipped_samples_are_told_and_harm_nothing():
    values = band(np.random.default_rng(SEED), 75.0, 85.0)
    assert flags_of(np.clip(values, -2.8, 2.8)) == ('clipped_seldom',), f'seed {SEED}'


@pytest.mark.parametrize(
    'change',
    [
        lambda values: values,
        lambda values: np.round(12.0 * values) / 12.0,
        lambda values: np.round(2.0 * values) / 2.0,
        lambda values: np.round(60.0 * np.sin(2 * np.pi * 7.3 * np.arange(N) / RATE_HZ)) / 60.0,
        lambda values: np.sin(2 * np.pi * 32.0 * np.arange(N) / RATE_HZ),
        lambda values: np.maximum(np.round(20.0 * (values - 3.0)), 0.0),
    ],
    ids=['random', 'coarse', 'very coarse', 'tone in steps', 'tone that repeats', 'rest and taps'],
)
def test_what_repeats_values_by_nature_is_not_clipped(change):
    found = flags_of(change(band(np.random.default_rng(SEED), 5.0, 90.0)))
    assert not {'clipping', 'clipped_seldom'} & set(found), f'seed {SEED}'


def test_zeros_in_place_of_samples_are_no_limit():
    values = 9.81 + band(np.random.default_rng(SEED), 5.0, 90.0)
    values[::3] = 0.0
    assert n_on_flat_top(-values) == 0


def test_an_overload_is_told_once():
    """Values at a limit stand still and repeat because of it."""
    values = (
        np.random.default_rng(SEED).standard_normal((N, 2))
        + band(np.random.default_rng(SEED + 1), 0.5, 2.0)[:, None]
    )
    values[:, 1] = np.clip(values[:, 1], -0.3, 0.3)
    buffer = SampleBuffer(IdentificationSettings(window_s=20.0, hop_s=20.0))
    for first in range(0, N, 256):
        stamp = START + round(first / RATE_HZ * 1e9)
        rows = values[first : first + 256]
        buffer.add(SampleBlock('/block', stamp, first, RATE_HZ, ('a', 'b'), rows))
    healthy, clipped = next(iter(buffer.windows())).quality.channels
    assert healthy.flags == () and clipped.flags == ('clipping',), f'seed {SEED + 1}'
