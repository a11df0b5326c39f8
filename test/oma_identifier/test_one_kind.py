"""Velocities, displacements and strains beside accelerations: one shape, nobody late."""

from dataclasses import replace

import numpy as np
import pytest

from modal_core.channel import Channel
from modal_core.measurements import SampleBlock
from modal_core.numbers.indicators import mac
from modal_core.samples import Samples
from oma_identifier.identify import identify_samples
from oma_identifier.one_kind import of_one_kind
from oma_identifier.pipeline import IdentificationPipeline
from oma_identifier.settings import IdentificationSettings

RATE_HZ, DURATION_S, SEED = 128.0, 120.0, 31
FREQUENCY_HZ = np.array([3.1, 7.4, 11.8, 17.3])
DAMPING = np.array([0.015, 0.012, 0.02, 0.01])
UNITS = ('m/s^2', 'm/s', 'm', 'm/s^2', 'm/s', 'm/s^2', 'm', 'm/m')
NOISE = 0.02


@pytest.fixture(scope='module')
def structure():
    """Return shapes, and modal displacements, velocities and accelerations under noise."""
    rng = np.random.default_rng(SEED)
    fine = 16
    n = round(DURATION_S * RATE_HZ) * fine
    omega = 2.0 * np.pi * FREQUENCY_HZ
    turn = 2j * np.pi * np.fft.rfftfreq(n, 1.0 / (RATE_HZ * fine))[:, None]
    force = np.fft.rfft(rng.standard_normal((n, len(omega))), axis=0) * omega
    motion = force / (turn**2 + 2.0 * DAMPING * omega * turn + omega**2)
    # The recorder's anti-aliasing filter.
    motion[np.abs(turn[:, 0]) > 2.0 * np.pi * 0.45 * RATE_HZ] = 0.0
    derived = [np.fft.irfft(motion * turn**k, n, axis=0)[::fine] for k in range(3)]
    shapes = rng.standard_normal((len(UNITS), len(omega)))
    return shapes, derived


def recorded(structure, units):
    """Return what channels of some units record, with noise of each."""
    rng = np.random.default_rng(SEED + 1)
    shapes, derived = structure
    channels = tuple(Channel(f's{n}', unit=unit) for n, unit in enumerate(units))
    columns = [
        derived[channel.times_derived] @ row for channel, row in zip(channels, shapes, strict=True)
    ]
    data = np.column_stack(columns)
    data += NOISE * data.std(axis=0) * rng.standard_normal(data.shape)
    return Samples(data, RATE_HZ, channels, 1_700_000_000_000_000_000)


def blocks(samples):
    names, units = samples.channel_names, tuple(channel.unit for channel in samples.channels)
    for first in range(0, len(samples.acceleration), 64):
        stamp_ns = samples.start_ns + round(first / RATE_HZ * 1e9)
        rows = samples.acceleration[first : first + 64]
        yield SampleBlock('daq', stamp_ns, first, RATE_HZ, names, rows, units)


def check(modes, shapes):
    assert len(modes) == len(FREQUENCY_HZ), f'seed {SEED}: {modes.frequency_hz}'
    assert np.allclose(modes.frequency_hz, FREQUENCY_HZ, rtol=0.01), f'seed {SEED}'
    assert np.all(np.diag(mac(shapes, modes.shapes)) > 0.99), f'seed {SEED}'
    assert all(mode.mpc > 0.98 for mode in modes), f'seed {SEED}'


def test_channels_of_all_kinds_give_one_shape(structure):
    samples = recorded(structure, UNITS)
    check(identify_samples(samples).modes, structure[0])


def test_no_kind_is_taken_for_a_late_sensor(structure):
    """A velocity is a quarter of a period behind the acceleration at every frequency."""
    pipeline = IdentificationPipeline(IdentificationSettings(window_s=60.0))
    results = []
    for block in blocks(recorded(structure, UNITS)):
        pipeline.add(block)
        results += [pipeline.identify(window) for window in pipeline.windows()]
    results += [pipeline.identify(window) for window in pipeline.finish()]
    flags = {flag for result in results for c in result.quality.channels for flag in c.flags}
    assert flags == set() and not any(c.excluded for c in results[0].quality.channels)
    assert len(results) == 3
    check(pipeline.whole().modes, structure[0])


def test_a_late_velocity_sensor_is_still_put_in_step(structure):
    samples = recorded(structure, UNITS)
    late = samples.acceleration.copy()
    late[6:, 1] = samples.acceleration[:-6, 1]
    pipeline = IdentificationPipeline(IdentificationSettings(window_s=60.0))
    for block in blocks(replace(samples, acceleration=late)):
        pipeline.add(block)
    result = pipeline.identify(next(pipeline.windows()))
    second = result.quality.channels[1]
    assert second.flags == ('not_synchronous',) and not second.excluded
    assert abs(second.lag_s - 6 / RATE_HZ) < max(4.0 * second.lag_std_s, 5e-4), f'seed {SEED}'
    check(result.modes, structure[0])


@pytest.mark.parametrize('unit', ['m/s', 'm', 'm/m'])
def test_one_kind_alone_is_identified_as_it_is(structure, unit):
    samples = recorded(structure, (unit,) * len(UNITS))
    assert of_one_kind(samples) is samples
    check(identify_samples(samples).modes, structure[0])


def test_what_comes_between_is_differentiated_exactly():
    time = np.arange(2000) / RATE_HZ
    omega = 2.0 * np.pi * np.array([0.5, 5.0, 20.0, 40.0])
    position = np.sin(np.outer(time, omega)).sum(axis=1)
    speed = (omega * np.cos(np.outer(time, omega))).sum(axis=1)
    acceleration = -(omega**2 * np.sin(np.outer(time, omega))).sum(axis=1)
    channels = (Channel('a'), Channel('v', unit='m/s'), Channel('d', unit='m'))
    mixed = Samples(np.column_stack([acceleration, speed, position + 7.0]), RATE_HZ, channels, 5)
    found = of_one_kind(mixed)
    assert {channel.unit for channel in found.channels} == {'m/s^2'}
    first = round((found.start_ns - 5) * 1e-9 * RATE_HZ)
    assert np.array_equal(found.acceleration[:, 0], acceleration[first : len(time) - first])
    for column in (1, 2):
        error = found.acceleration[:, column] - found.acceleration[:, 0]
        assert np.abs(error).max() < 1e-3 * acceleration.std()
