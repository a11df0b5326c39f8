"""Sensors that are not synchronous, without joint states: put in step, or named and left out."""

from dataclasses import replace

import numpy as np
import pytest

from modal_core.channel import Channel
from modal_core.measurements import SampleBlock, StampedSamples
from modal_core.numbers.indicators import mac
from modal_core.samples import Samples
from modal_core.window import Window
from oma_identifier.motion.robot_signals import RobotSignals
from oma_identifier.pipeline import IdentificationPipeline
from oma_identifier.settings import IdentificationSettings
from oma_identifier.synchrony.in_step import columns_of, Synchroniser
from oma_identifier.synchrony.sensor_delay import sensor_delays
from oma_identifier.synchrony.sensor_peaks import sensor_peaks
from oma_identifier.synchrony.thresholds import SYNCHRONY

SEED = 20
RATE_HZ = 200.0
FREQUENCY_HZ = np.array([6.2, 11.0, 17.0, 24.0, 33.0, 47.0])
DAMPING = np.array([0.012, 0.01, 0.015, 0.008, 0.012, 0.01])
NAMES = tuple(f'imu{number}.{axis}' for number in range(4) for axis in 'xy')
LATE_SENSOR = 'imu2'
SETTLE_S = 4.0


def record(rng, shapes, delay_s, duration_s=130.0, names=NAMES, **changes):
    """Return responses to independent forces, each channel late by exactly its delay."""
    known = {'frequency_hz': FREQUENCY_HZ, 'damping': DAMPING, 'rate_hz': RATE_HZ, 'noise': 0.05}
    known |= changes
    rate_hz, omega = known['rate_hz'], 2.0 * np.pi * known['frequency_hz'][:, None]
    n = round((duration_s + 2.0 * SETTLE_S) * rate_hz)
    line = np.fft.rfftfreq(n, 1.0 / rate_hz)
    s = 2j * np.pi * line
    force = rng.standard_normal((len(omega), len(line), 2)) @ (1.0, 1j)
    if 'own_force' in changes:
        # One force drives all modes; each has this share of its own beside.
        force = force[0] + known['own_force'] * force
    zeta = known['damping'][:, None]
    modal = s**2 / (s**2 + 2.0 * zeta * omega * s + omega**2) * force * np.sqrt(zeta)
    response = shapes @ modal
    if 'beat_s' in changes:
        # Each mode comes to one sensor with a delay of its beat alone.
        away_hz = line - known['frequency_hz'][:, None]
        own = [name.startswith(LATE_SENSOR) for name in names]
        turn = np.exp(-2j * np.pi * away_hz * changes['beat_s'][:, None])
        response[own] = shapes[own] @ (modal * turn)
    response = response * (line < 0.45 * rate_hz)
    response *= np.exp(-np.outer(delay_s, s))
    first = round(SETTLE_S * rate_hz)
    data = np.fft.irfft(response, n, axis=1).T[first : first + round(duration_s * rate_hz)]
    data = data + known['noise'] * data.std(axis=0) * rng.standard_normal(data.shape)
    return Samples(data, rate_hz, tuple(Channel(name) for name in names))


def late(seconds, sensor=LATE_SENSOR):
    return np.array([seconds if name.startswith(sensor) else 0.0 for name in NAMES])


def one_recorder(samples):
    """Yield blocks of one recorder, which knows one clock only."""
    size = round(samples.sample_rate_hz)
    for first in range(0, len(samples.acceleration), size):
        yield SampleBlock(
            source='acceleration_block',
            stamp_ns=10**12 + round(first / samples.sample_rate_hz * 1e9),
            first_index=first,
            sample_rate_hz=samples.sample_rate_hz,
            channel_names=samples.channel_names,
            acceleration=samples.acceleration[first : first + size].astype(np.float32),
        )


def topic_per_sensor(samples):
    """Yield messages of separate sensors, two axes each, stamped when they are sent."""
    size = round(samples.sample_rate_hz)
    for first in range(0, len(samples.acceleration), size):
        rows = samples.acceleration[first : first + size]
        stamp_ns = 10**12 + np.round(
            (first + np.arange(len(rows))) / samples.sample_rate_hz * 1e9
        ).astype(np.int64)
        for sensor in range(len(NAMES) // 2):
            own = slice(2 * sensor, 2 * sensor + 2)
            yield StampedSamples(
                f'imu{sensor}', 'link', stamp_ns, rows[:, own], channel_names=NAMES[own]
            )


def identified(measurements, **settings):
    chosen = IdentificationSettings(window_s=60.0, hop_s=30.0, refine=False, **settings)
    pipeline, results = IdentificationPipeline(chosen), []
    for measurement in measurements:
        pipeline.add(measurement)
        results += [pipeline.identify(window) for window in pipeline.windows()]
    return [*results, *(pipeline.identify(w) for w in pipeline.finish()), pipeline.whole()]


def assert_true_shapes(result, shapes):
    """All modes are there, each with the shape it has on the channels that are named."""
    rows = [NAMES.index(name) for name in result.modes.channel_names if name in NAMES]
    columns = [result.modes.channel_names.index(NAMES[row]) for row in rows]
    found = result.modes.frequency_hz
    assert len(found) == len(FREQUENCY_HZ), f'seed {SEED}: {found}'
    np.testing.assert_allclose(found, FREQUENCY_HZ, rtol=0.01)
    for mode, shape in zip(result.modes, shapes.T, strict=True):
        agreement = float(mac(mode.shape[columns], shape[rows])[0, 0])
        assert agreement > 0.99, f'seed {SEED}: {mode.frequency_hz} Hz, MAC {agreement}'


@pytest.mark.slow
@pytest.mark.parametrize('delay_s', [0.002, 0.005, 0.0137, 0.05, -0.2])
@pytest.mark.parametrize('arrives', [one_recorder, topic_per_sensor])
def test_a_late_sensor_loses_no_mode_and_turns_no_shape(delay_s, arrives):
    rng = np.random.default_rng(SEED)
    shapes = rng.standard_normal((len(NAMES), len(FREQUENCY_HZ)))
    results = identified(arrives(record(rng, shapes, late(delay_s))))
    for result in results:
        assert_true_shapes(result, shapes)
        late_ones = {c.name for c in result.quality.channels if 'not_synchronous' in c.flags}
        assert late_ones == {n for n in result.modes.channel_names if n.startswith(LATE_SENSOR)}
    for channel in results[0].quality.channels:
        if channel.name.startswith(LATE_SENSOR):
            assert abs(channel.lag_s - delay_s) < 4.0 * channel.lag_std_s < 4e-4, f'seed {SEED}'


def test_every_sensor_with_a_delay_of_its_own():
    rng = np.random.default_rng(SEED)
    shapes = rng.standard_normal((len(NAMES), len(FREQUENCY_HZ)))
    delay_s = np.repeat([0.0, 0.003, 0.011, -0.02], 2)
    for result in identified(one_recorder(record(rng, shapes, delay_s))):
        assert_true_shapes(result, shapes)


def test_a_sensor_that_no_delay_puts_in_step_is_left_out_and_named():
    """Its filter turns every mode by an angle of its own, and delays its beat."""
    rng = np.random.default_rng(SEED)
    shapes = rng.standard_normal((len(NAMES), len(FREQUENCY_HZ)))
    turn = np.exp(1j * np.array([1.3, -1.2, 1.5, 0.9, -1.4, 1.1]))
    turned = np.where(late(1.0)[:, None] > 0.0, shapes * turn, shapes)
    beat_s = np.array([0.3, -0.2, 0.25, -0.35, 0.15, -0.1])
    for result in identified(one_recorder(record(rng, turned, late(0.0), beat_s=beat_s))):
        assert LATE_SENSOR not in ' '.join(result.modes.channel_names)
        assert_true_shapes(result, shapes)
        for channel in result.quality.channels:
            is_late = channel.name.startswith(LATE_SENSOR)
            assert channel.excluded == ('not_synchronous' in channel.flags) == is_late


@pytest.mark.parametrize('seed', [21, 22])
def test_sensors_across_a_turning_shaft_are_not_late(seed):
    """Each mode is a circle: forward or backward, a quarter of a turn between x and y."""
    rng = np.random.default_rng(seed)
    size = rng.uniform(0.3, 1.0, (len(NAMES) // 2, len(FREQUENCY_HZ)))
    size *= rng.choice([-1.0, 1.0], size.shape)
    shapes = np.empty((len(NAMES), len(FREQUENCY_HZ)), dtype=complex)
    shapes[::2] = size
    shapes[1::2] = 1j * rng.choice([-1.0, 1.0], len(FREQUENCY_HZ)) * size
    # Each axis is a sensor of its own.
    names = tuple(name.replace('.', '_') for name in NAMES)
    samples = record(rng, shapes, np.zeros(len(NAMES)), names=names)
    for result in identified(one_recorder(samples)):
        assert result.modes.channel_names == names, f'seed {seed}'
        found = result.modes.frequency_hz
        assert len(found) == len(FREQUENCY_HZ), f'seed {seed}: {found}'
        for mode, shape in zip(result.modes, shapes.T, strict=True):
            assert float(mac(mode.shape, shape)[0, 0]) > 0.98, f'seed {seed}: {mode.frequency_hz}'
        flags = [channel.flags for channel in result.quality.channels]
        assert any('phases_turned' in each for each in flags), f'seed {seed}: {flags}'


def test_planes_that_one_force_shakes_together_are_not_late():
    """A beam sways in two planes, and one shock shakes both: they are in step, not in phase.

    What a sensor shows at a mode of the other plane are flanks of its own modes, which the force
    keeps in step with it.
    """
    odd = []
    for seed in range(12):
        rng = np.random.default_rng((SEED, seed))
        shapes = rng.standard_normal((len(NAMES), len(FREQUENCY_HZ)))
        across = np.arange(len(NAMES))[:, None] % 2 != np.arange(len(FREQUENCY_HZ)) % 2
        shapes *= np.where(across, 0.02, 1.0)
        names = tuple(name.replace('.', '_') for name in NAMES)
        samples = record(
            rng, shapes, np.zeros(len(NAMES)), 60.0, names, own_force=0.05, noise=0.003
        )
        columns = {name: np.array([place]) for place, name in enumerate(names)}
        found = sensor_delays(sensor_peaks(samples), columns)
        odd += [(seed, name) for name, delay in found.items() if delay.is_odd]
    # Of 96 sensors; 0.1 % is what the odds promise.
    assert not odd, f'seed {SEED}: {odd}'


def test_a_clock_that_steps_between_windows_is_followed():
    rng = np.random.default_rng(SEED)
    shapes = rng.standard_normal((len(NAMES), len(FREQUENCY_HZ)))
    whole = record(rng, shapes, late(0.0), duration_s=240.0)
    data, middle, step = whole.acceleration.copy(), 120 * int(RATE_HZ), 4
    data[middle:, 4:6] = data[middle - step : -step, 4:6]
    results = identified(one_recorder(replace(whole, acceleration=data)))
    lags = [result.quality.channels[4].lag_s for result in results[:-1]]
    assert np.isnan(lags[:3]).all()
    np.testing.assert_allclose(lags[4:], step / RATE_HZ, atol=3e-4)
    for result in results[:-1]:
        assert_true_shapes(result, shapes)
    # The window that holds the step does without the sensor, and says so.
    for channel in results[3].quality.channels:
        is_late = channel.name.startswith(LATE_SENSOR)
        assert channel.excluded == bool(channel.flags) == is_late, f'seed {SEED}'


def test_a_clock_that_is_set_back_does_not_hide_delays():
    """Delays are looked for in every record, also in one of an earlier time than the last."""
    rng = np.random.default_rng(SEED)
    shapes = rng.standard_normal((len(NAMES), len(FREQUENCY_HZ)))
    clean, synchronise = RobotSignals(None), Synchroniser()
    before = replace(record(rng, shapes, late(0.0), duration_s=60.0), start_ns=4 * 10**12)
    after = replace(record(rng, shapes, late(0.02), duration_s=60.0), start_ns=10**12)
    assert not synchronise.align(clean.clean(Window(0, before))).lags
    lags = synchronise.align(clean.clean(Window(1, after))).lags
    assert {name for name in lags if name.startswith(LATE_SENSOR)} == set(NAMES[4:6])
    assert lags[NAMES[4]].seconds == pytest.approx(0.02, abs=3e-4)


@pytest.mark.parametrize('imaginary', [0.0, 0.3])
def test_synchronous_sensors_of_random_structures_are_left_alone(imaginary):
    """Bit for bit: the very same samples go on, whatever the structure is like."""
    n_sensors = n_odd = 0
    for seed in range(30):
        rng = np.random.default_rng((SEED, seed))
        n_modes, n_sensors_here = int(rng.integers(2, 13)), int(rng.integers(2, 9))
        names = tuple(f's{n}.{a}' for n in range(n_sensors_here) for a in 'xyz'[: 1 + n % 3])
        shapes = rng.standard_normal((2, len(names), n_modes))
        samples = record(
            rng,
            shapes[0] + 1j * imaginary * shapes[1],
            np.zeros(len(names)),
            rng.uniform(20.0, 120.0),
            names,
            rate_hz=float(rng.choice([50.0, 200.0, 500.0])),
            noise=10.0 ** rng.uniform(-3.0, -0.7),
            frequency_hz=np.sort(rng.uniform(1.0, 20.0, n_modes)),
            damping=10.0 ** rng.uniform(-3.0, -1.3, n_modes),
        )
        n_sensors += n_sensors_here
        cleaned = RobotSignals(None).clean(Window(0, samples))
        in_step = Synchroniser().align(cleaned)
        n_odd += sum('not_synchronous' in flag for flag in in_step.channel_flags.values())
        if not in_step.channel_flags:
            assert in_step is cleaned
    assert n_sensors > 100 and n_odd == 0, f'seed {SEED}: {n_odd} of {n_sensors}'


def test_the_deviation_of_a_delay_is_that_of_its_error():
    errors = []
    sensors = np.array([name[:4] for name in NAMES])
    columns = {name: np.flatnonzero(sensors == name) for name in dict.fromkeys(sensors)}
    for seed in range(25):
        rng = np.random.default_rng((SEED, seed))
        shapes = rng.standard_normal((len(NAMES), len(FREQUENCY_HZ)))
        truth = float(rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-2.3, -0.7))
        peaks = sensor_peaks(record(rng, shapes, late(truth), 60.0))
        found = sensor_delays(peaks, columns)[LATE_SENSOR]
        assert found.log_odds > np.log(SYNCHRONY.delay_odds) and found.is_known, (
            f'seed {SEED}, {seed}: {truth}'
        )
        errors.append((found.seconds - truth) / found.std_s)
    assert np.max(np.abs(errors)) < 4.0 and np.std(errors) < 1.5, f'seed {SEED}: {errors}'


def swept(delay_s, orders=(1.0, 2.0, 3.0), from_hz=18.0, to_hz=20.0, duration_s=60.0):
    """Return the orders of a shaft whose speed grows, each channel late by its delay."""
    at_s = np.arange(round(duration_s * RATE_HZ))[:, None] / RATE_HZ - delay_s
    turns = from_hz * at_s + 0.5 * (to_hz - from_hz) / duration_s * at_s**2
    return np.sum([np.cos(2.0 * np.pi * order * turns) for order in orders], axis=0)


def test_a_machine_whose_speed_grows_tells_no_delay():
    """Its lines have the phases of all modes they move at once; a sensor is not late by that."""
    rng = np.random.default_rng(SEED)
    shapes = rng.standard_normal((len(NAMES), len(FREQUENCY_HZ)))
    modes = record(rng, shapes, np.zeros(len(NAMES)), duration_s=60.0)
    lines = 10.0 * modes.acceleration.std(axis=0) * swept(late(0.03))
    both = replace(modes, acceleration=modes.acceleration + lines)
    peaks = sensor_peaks(both)
    of_lines = [peak for peak in peaks if peak.is_line]
    found_hz = sorted(peak.frequency_hz for peak in of_lines)
    np.testing.assert_allclose(found_hz, [19.0, 38.0, 57.0], rtol=0.01, err_msg=f'seed {SEED}')
    assert not any(peak.is_line for peak in sensor_peaks(modes)), f'seed {SEED}'
    found = sensor_delays(of_lines, columns_of(both.channels))
    assert not any(delay.is_odd for delay in found.values()), f'seed {SEED}'
