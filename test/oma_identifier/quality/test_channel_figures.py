"""Noise floor and kurtosis of channels, against signals of known noise and distribution."""

import numpy as np
import pytest

from oma_identifier.quality.health import examine, noise_rms, summarise

RATE_HZ, SEED = 1000.0, 12
TIME_S = np.arange(60_000) / RATE_HZ


def vibration(rng):
    """Return three slow channels (up to 30 Hz) of rms 1."""
    slow = sum(
        rng.normal(size=3) * np.sin(2 * np.pi * f * TIME_S[:, None] + rng.uniform(0, 6, 3))
        for f in np.linspace(2.0, 30.0, 40)
    )
    return slow / slow.std(axis=0)


@pytest.mark.parametrize('noise', [0.05, 0.1, 1.0])
def test_the_noise_floor_is_found_under_vibration(noise):
    rng = np.random.default_rng(SEED)
    values = vibration(rng) + noise * rng.standard_normal((len(TIME_S), 3))
    np.testing.assert_allclose(noise_rms(values), noise, rtol=0.25, err_msg=f'seed {SEED}')


def test_below_what_vibration_leaves_it_is_an_upper_bound():
    rng = np.random.default_rng(SEED)
    values = vibration(rng) + 1e-3 * rng.standard_normal((len(TIME_S), 3))
    found = noise_rms(values)
    # The second difference of a tone of 30 Hz and rms 1 at 1 kHz has an rms of 0.036.
    assert np.all((found > 1e-3) & (found < 0.036 / np.sqrt(6.0))), f'{found}, seed {SEED}'


def test_knocks_are_no_noise_but_kurtosis():
    rng = np.random.default_rng(SEED)
    values = 0.1 * rng.standard_normal((len(TIME_S), 2))
    values[rng.integers(0, len(values), 200), 1] += 5.0
    quiet, knocked = examine(values, summarise(values))
    assert quiet.kurtosis == pytest.approx(3.0, abs=0.1)
    assert knocked.kurtosis > 30.0 and 'impulsive' in knocked.flags
    assert knocked.noise_rms == pytest.approx(0.1, rel=0.2)


def test_a_tone_has_kurtosis_one_and_a_half_and_a_flat_line_none():
    values = np.column_stack([np.sin(2 * np.pi * 10.0 * TIME_S), np.full(len(TIME_S), 2.0)])
    tone, flat = examine(values, summarise(values))
    assert tone.kurtosis == pytest.approx(1.5, abs=0.01)
    assert np.isnan(flat.kurtosis) and flat.noise_rms == 0.0
    assert 'flatline' in flat.flags


def test_two_rows_are_too_few_to_tell():
    assert np.isnan(noise_rms(np.ones((2, 3)))).all()
