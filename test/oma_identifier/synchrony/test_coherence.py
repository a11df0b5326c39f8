"""Sensors that show another motion than the others are found, named and left out."""

import numpy as np
import pytest
from scipy.signal import lfilter

from modal_core.channel import Channel
from modal_core.numbers.indicators import mac
from modal_core.samples import Samples
from oma_identifier.identify import identify_samples
from oma_identifier.motion.robot_signals import Cleaned, never
from oma_identifier.synchrony.coherence import check_coherence
from oma_identifier.synchrony.in_step import columns_of, Synchroniser
from oma_identifier.synchrony.multiple_coherence import residual_of
from oma_identifier.synchrony.sensor_peaks import sensor_peaks

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
    return {Channel(name=name).sensor: flag for name, flag in cleaned.channel_flags.items()}


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


@pytest.mark.parametrize('name', ['set1', 'set2'])
def test_healthy_sensors_of_a_building_stay_in_all_windows(data_path, name):
    """Sensors that move little at a peak show neighbouring modes there, and are named at most."""
    rows = np.load(data_path('pyoma2_3SL_simulated', f'{name}.npy'))
    channels = tuple(Channel(f'ch{number}') for number in range(rows.shape[1]))
    window = 6000
    for first in range(0, len(rows) - window + 1, window // 2):
        samples = Samples(rows[first : first + window], 100.0, channels)
        found = check_coherence(samples, sensor_peaks(samples), columns_of(channels))
        assert not found.left_out, f'from {first / 100.0:g} s'


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


def test_what_is_left_of_all_sensors_at_once_is_what_least_squares_leave_of_each():
    rng = np.random.default_rng((SEED, 400))
    values = rng.standard_normal((300, 6, 2)) @ (1.0, 1.0j)
    values[:, 3] = values[:, :3] @ (1.0, -0.5, 0.3j) + 0.1 * values[:, 3]
    sensors = [np.array([0, 1]), np.array([2]), np.array([3, 4]), np.array([5])]
    rest = residual_of(values.conj().T @ values, sensors, n_free=300.0)
    for number, own in enumerate(sensors):
        others = np.delete(values, own, axis=1)
        left = values[:, own] - others @ np.linalg.lstsq(others, values[:, own])[0]
        assert rest.power[number] == pytest.approx(np.sum(np.abs(left) ** 2), rel=1e-6)
        assert rest.n_used[number] == pytest.approx(6 - len(own), rel=1e-6)


def test_no_more_coefficients_are_estimated_than_half_the_values_can_tell():
    rng = np.random.default_rng((SEED, 401))
    values = rng.standard_normal((12, 40, 2)) @ (1.0, 1.0j)
    each = [np.array([number]) for number in range(40)]
    rest = residual_of(values.conj().T @ values, each, n_free=12.0)
    assert (rest.n_used < 6.0).all() and (rest.n_used > 4.0).all()
    total = np.sum(np.abs(values) ** 2, axis=0)
    # Of noise chance explains its share, and that share is known.
    share = np.mean(1.0 - rest.power / total)
    assert share == pytest.approx(np.mean(rest.n_used) / 12.0, abs=0.15)


@pytest.mark.parametrize('axes', [1, 3])
def test_in_crowded_structures_of_heavy_damping_no_healthy_sensor_is_suspected(structure, axes):
    """More modes overlap at a peak than a few directions hold, and a plateau looks like noise."""
    n_flagged = 0
    for seed in range(10):
        rng = np.random.default_rng((SEED, 500 + seed))
        hz = np.sort(np.exp(rng.uniform(np.log(3.0), np.log(45.0), 8)))
        plant = structure(hz, rng.uniform(0.05, 0.1, 8), n_channels=12, seed=seed)
        samples = plant.simulate(rng, 30.0, 128.0, 0.05)
        names = NAMES if axes == 3 else [f'c{number}' for number in range(12)]
        channels = tuple(Channel(name=name) for name in names)
        cleaned = looked_at(Samples(samples.acceleration, 128.0, channels), slice(None))
        assert not cleaned.left_out, f'seed {SEED}, {seed}'
        n_flagged += len(cleaned.channel_flags)
    assert n_flagged <= 1, f'seed {SEED}: {n_flagged} of 120 channels'
