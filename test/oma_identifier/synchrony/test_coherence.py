"""Sensors that show another motion than the others are found, named and left out."""

import numpy as np
import pytest
from scipy.signal import lfilter

from modal_core.channel import Channel
from modal_core.indicators import mac
from modal_core.samples import Samples
from oma_identifier.identify import identify_samples
from oma_identifier.motion.robot_signals import Cleaned, never
from oma_identifier.synchrony.in_step import sensor_of, Synchroniser

SEED = 31_700
RATE_HZ = 200.0
FREQUENCY_HZ = (8.3, 13.1, 21.7, 33.9, 52.2)
DAMPING = (0.012, 0.02, 0.008, 0.015, 0.01)
NAMES = tuple(
    f'{sensor}.{axis}' for sensor in ('base', 'elbow', 'wrist', 'tool') for axis in 'xyz'
)


@pytest.fixture
def record(structure):
    """Return a function that makes a record; the seed draws forces and noise."""

    def make(seed, noise=0.02):
        plant = structure(FREQUENCY_HZ, DAMPING, n_channels=12, seed=SEED)
        samples = plant.simulate(np.random.default_rng((SEED, seed)), 90.0, RATE_HZ, noise)
        channels = tuple(Channel(name=name) for name in NAMES)
        return plant, Samples(samples.acceleration, RATE_HZ, channels)

    return make


def looked_at(samples, rows=slice(0, 12_000)):
    part = Samples(samples.acceleration[rows].copy(), RATE_HZ, samples.channels)
    return Synchroniser().align(Cleaned(part, (), never, (), {}))


def flags_of(cleaned):
    return {sensor_of(Channel(name=name)): flag for name, flag in cleaned.channel_flags.items()}


def stale(values):
    return np.roll(values, 15 * int(RATE_HZ), axis=0)


def drifting(values):
    time = np.arange(len(values))
    late = time + 4.0 * np.maximum(0.0, time - 4000) / 4000
    return np.column_stack([np.interp(late, time, column) for column in values.T])


def every_third(values):
    """What a third of the samples makes of the rest: images below a third of half the rate."""
    spectrum = np.fft.rfft(values[::3], axis=0)
    return 3.0 * np.fft.irfft(spectrum, n=len(values), axis=0)


@pytest.mark.parametrize('fault', [stale, drifting, every_third])
def test_a_sensor_that_contradicts_the_others_is_left_out(record, fault):
    _, samples = record(1)
    values = samples.acceleration.copy()
    values[:, 6:9] = fault(values[:, 6:9])
    cleaned = looked_at(Samples(values, RATE_HZ, samples.channels))
    assert flags_of(cleaned)['wrist'] in ('incoherent', 'not_synchronous'), f'seed {SEED}'
    assert set(cleaned.left_out) == {'wrist.x', 'wrist.y', 'wrist.z'}
    assert set(flags_of(cleaned)) == {'wrist'}
    assert len(cleaned.samples.channels) == 9


def test_what_is_left_gives_the_modes(record):
    plant, samples = record(2)
    values = samples.acceleration.copy()
    values[:, 0:3] = stale(values[:, 0:3])
    modes = identify_samples(looked_at(Samples(values, RATE_HZ, samples.channels)).samples).modes
    assert len(modes) == len(FREQUENCY_HZ)
    for mode, truth in zip(modes, plant.shapes[3:].T, strict=True):
        assert mac(mode.shape, truth)[0, 0] > 0.98, f'seed {SEED}'


def test_of_two_sensors_that_contradict_each_other_neither_is_believed(record):
    _, samples = record(3)
    values = samples.acceleration[:, :6].copy()
    values[:, 3:] = stale(values[:, 3:])
    cleaned = looked_at(Samples(values, RATE_HZ, samples.channels[:6]))
    assert flags_of(cleaned) == {'base': 'incoherent', 'elbow': 'incoherent'}
    assert not cleaned.left_out


def test_a_channel_that_hears_only_its_own_noise_is_named(record):
    _, samples = record(4)
    values = samples.acceleration.copy()
    rng = np.random.default_rng((SEED, 44))
    values[:, 7] = 0.3 * rng.standard_normal(len(values))
    cleaned = looked_at(Samples(values, RATE_HZ, samples.channels))
    assert cleaned.channel_flags == {'wrist.y': 'no_response'}
    assert not cleaned.left_out


def test_a_sensor_with_a_peak_of_its_own_is_left_out(record):
    """Its bracket rattles: nobody else shows it, and an image would look the same."""
    _, samples = record(5)
    values = samples.acceleration.copy()
    turn, r = 2.0 * np.pi * 43.0 / RATE_HZ, 0.98
    force = np.random.default_rng((SEED, 55)).standard_normal(len(values))
    rattle = lfilter([1.0], [1.0, -2.0 * r * np.cos(turn), r * r], force)
    values[:, 9:] += rattle[:, None] / rattle.std() * values[:, 9:].std(axis=0)
    cleaned = looked_at(Samples(values, RATE_HZ, samples.channels))
    assert flags_of(cleaned) == {'tool': 'incoherent'}, f'seed {SEED}'
    assert set(cleaned.left_out) == {'tool.x', 'tool.y', 'tool.z'}


@pytest.mark.parametrize('noise', [0.003, 0.1, 1.0])
def test_healthy_sensors_are_not_suspected(record, noise):
    for seed in range(8):
        _, samples = record(100 + seed, noise)
        cleaned = looked_at(samples)
        assert not cleaned.channel_flags and not cleaned.left_out, f'seed {SEED}, {seed}'


def test_damped_and_close_modes_are_coherent(structure):
    for seed in range(8):
        rng = np.random.default_rng((SEED, 200 + seed))
        hz = np.sort(rng.uniform(5.0, 70.0, 6))
        hz[1] = hz[0] * 1.01
        plant = structure(hz, 10 ** rng.uniform(-3.0, -1.0, 6), n_channels=12, seed=seed)
        samples = plant.simulate(rng, 60.0, RATE_HZ, 0.05)
        channels = tuple(Channel(name=name) for name in NAMES)
        cleaned = looked_at(Samples(samples.acceleration, RATE_HZ, channels))
        assert 'incoherent' not in cleaned.channel_flags.values(), f'seed {SEED}, {seed}'


@pytest.mark.parametrize('n_channels', [2, 3])
def test_a_few_channels_contradict_nobody(structure, n_channels):
    """Two channels cannot tell overlapping modes apart: healthy ones need not be coherent."""
    for seed in range(8):
        rng = np.random.default_rng((SEED, 300 + seed))
        plant = structure(FREQUENCY_HZ, DAMPING, n_channels=n_channels, seed=seed)
        samples = plant.simulate(rng, 60.0, RATE_HZ, 0.05)
        channels = tuple(Channel(name=f'c{number}') for number in range(n_channels))
        cleaned = looked_at(Samples(samples.acceleration, RATE_HZ, channels))
        assert not cleaned.channel_flags and not cleaned.left_out, f'seed {SEED}, {seed}'
