"""Modes under forces of which a part is known, against exact responses in time."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import cont2discrete, lfilter

from modal_core.channel import Channel
from modal_core.numbers.indicators import mac
from modal_core.samples import Samples
from oma_identifier.identify import identify_samples

RATE_HZ, DURATION_S, OVER = 64.0, 120.0, 6
FREQUENCY_HZ, DAMPING = np.array([4.1, 7.3, 8.2]), np.array([0.012, 0.02, 0.009])
N_CHANNELS, NOISE, SEED = 8, 0.01, 611


def band_limited(rng, n, n_columns):
    hz = np.fft.rfftfreq(n, 1.0 / RATE_HZ / OVER)[:, None]
    lines = rng.standard_normal((2, len(hz), n_columns))
    return np.fft.irfft((lines[0] + 1j * lines[1]) * ((hz > 0.5) & (hz < 26.0)), n, axis=0)


def modal_motion(force):
    """Return modal accelerations: exact for forces that are straight between their samples."""
    motion = np.empty_like(force)
    for column, (hz, ratio) in enumerate(zip(FREQUENCY_HZ, DAMPING, strict=True)):
        omega = 2.0 * np.pi * hz
        system = [1.0, 0.0, 0.0], [1.0, 2.0 * ratio * omega, omega**2]
        over, under, _ = cont2discrete(system, 1.0 / RATE_HZ / OVER, 'foh')
        motion[:, column] = lfilter(over.ravel(), under.ravel(), force[:, column])
    return motion


def simulated(seed, share, n_inputs=3, direct=0.5, delay_s=0.0):
    """Return samples with known inputs, and the shapes.

    ``share`` of the responses' power is due to the inputs; ``direct`` times a typical response of
    theirs moves the sensors directly.
    """
    rng = np.random.default_rng(seed)
    n = int(DURATION_S * RATE_HZ) * OVER
    shapes = rng.standard_normal((N_CHANNELS, len(FREQUENCY_HZ)))
    inputs = band_limited(rng, n, n_inputs)
    driven = modal_motion(inputs @ rng.standard_normal((n_inputs, len(FREQUENCY_HZ)))) @ shapes.T
    other = modal_motion(band_limited(rng, n, len(FREQUENCY_HZ))) @ shapes.T
    moved = inputs @ rng.standard_normal((n_inputs, N_CHANNELS)) / inputs.std() * direct
    data = np.sqrt(share) * (driven / driven.std() + moved)
    data = (data + np.sqrt(1.0 - share) * other / other.std())[::OVER]
    data += NOISE * rng.standard_normal(data.shape)
    known = np.roll(inputs, round(delay_s * RATE_HZ * OVER), axis=0)[::OVER]
    channels = tuple(Channel(f'c{number}') for number in range(N_CHANNELS))
    return Samples(data, RATE_HZ, channels, known=known), shapes


def errors(modes, shapes):
    """Return errors of f and ζ over their deviations, and of the MAC over its expected loss."""
    found = []
    for hz, ratio, shape in zip(FREQUENCY_HZ, DAMPING, shapes.T, strict=True):
        mode = min(modes, key=lambda one, hz=hz: abs(one.frequency_hz - hz))
        turned = 1.0 - float(mac(shape, mode.shape)[0, 0])
        found.append(
            (
                (mode.frequency_hz - hz) / mode.frequency_std_hz,
                (mode.damping_ratio - ratio) / mode.damping_ratio_std,
                turned / mode.mac_loss,
            )
        )
    return np.array(found)


@pytest.mark.parametrize(
    ('share', 'least', 'fewest'),
    [(0.6, 1.2, 2), pytest.param(0.99, 5.0, 3, marks=pytest.mark.slow)],
)
def test_known_motion_makes_modes_more_exact_and_says_so(share, least, fewest):
    """Where it explains little, the motion is not always the better estimate."""
    samples, shapes = simulated(SEED, share)
    known = identify_samples(samples)
    blind = identify_samples(replace(samples, known=None)).modes
    assert len(known.modes) == len(FREQUENCY_HZ)
    used = np.array([mode.known_motion for mode in known.modes])
    assert used.sum() >= fewest, f'seed {SEED}'
    assert 'known_motion' in known.quality.flags
    assert not any(mode.known_motion for mode in blind)
    off = errors(known.modes, shapes)
    assert np.all(np.abs(off[:, :2]) < 4.0), f'seed {SEED}: {off}'
    assert np.all(off[used, 2] < 8.0), f'seed {SEED}: {off}'
    for mode in (each for each in known.modes if each.known_motion):
        before = min(blind, key=lambda one, mode=mode: abs(one.frequency_hz - mode.frequency_hz))
        assert mode.frequency_std_hz * least < before.frequency_std_hz, f'seed {SEED}'
        assert mode.damping_ratio_std * least < before.damping_ratio_std, f'seed {SEED}'


def test_small_delays_of_the_inputs_do_no_harm():
    samples, shapes = simulated(SEED, 0.9, direct=0.1, delay_s=0.003)
    modes = identify_samples(samples).modes
    assert all(mode.known_motion for mode in modes)
    off = errors(modes, shapes)
    assert np.all(np.abs(off[:, :2]) < 4.0), f'seed {SEED}: {off}'


@pytest.mark.parametrize('direct', [0.1, pytest.param(1.0, marks=pytest.mark.slow)])
def test_shapes_under_one_force_that_moves_the_sensors_too_are_right_or_withheld(direct):
    samples, shapes = simulated(SEED + 4, 0.99, n_inputs=1, direct=direct)
    modes = identify_samples(samples).modes
    for mode in modes:
        loss = 1.0 - mac(shapes, mode.shape)[:, 0].max()
        assert mode.shape_std is None or loss < 8.0 * mode.mac_loss, f'seed {SEED + 4}: {mode}'


def reversed_in_time(known, rng):
    return known[::-1].copy()


def noise(known, rng):
    return rng.standard_normal(known.shape)


def frozen(known, rng):
    return np.zeros_like(known)


def unknown(known, rng):
    return np.full_like(known, np.nan)


@pytest.mark.parametrize(
    'wrong', [pytest.param(reversed_in_time, marks=pytest.mark.slow), noise, frozen, unknown]
)
def test_inputs_of_something_else_leave_everything_as_it_was(wrong):
    samples, _ = simulated(SEED + 1, 0.8)
    blind = identify_samples(replace(samples, known=None)).modes
    known = wrong(samples.known, np.random.default_rng(SEED))
    modes = identify_samples(replace(samples, known=known)).modes
    assert [repr(mode) for mode in modes] == [repr(mode) for mode in blind], f'seed {SEED}'


def test_late_inputs_are_left_out_or_do_no_harm():
    for seed in (SEED + 2, SEED + 3):
        samples, shapes = simulated(seed, 0.9, delay_s=0.1)
        off = errors(identify_samples(samples).modes, shapes)
        assert np.all(np.abs(off[:, :2]) < 4.5), f'seed {seed}: {off}'
