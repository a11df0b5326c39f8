"""Sensors that change within a record are named, left out meanwhile, and told apart since."""

from dataclasses import replace

import numpy as np
import pytest

from modal_core.channel import Channel
from modal_core.measurements import SampleBlock
from modal_core.numbers.indicators import mac
from modal_core.samples import Samples
from modal_core.window import Pose
from oma_identifier.motion import Cleaned, never
from oma_identifier.node.findings import quality_findings
from oma_identifier.pipeline import IdentificationPipeline
from oma_identifier.settings import IdentificationSettings
from oma_identifier.synchrony import CHANGES, SensorChanges, Synchroniser
from oma_identifier.time_axis import interpolate

SEED = 52_300
RATE_HZ = 200.0
FREQUENCY_HZ = (8.3, 13.1, 21.7, 33.9, 52.2)
DAMPING = (0.012, 0.02, 0.008, 0.015, 0.01)
SENSORS = ('base', 'elbow', 'wrist', 'tool')
NAMES = tuple(f'{sensor}.{axis}' for sensor in SENSORS for axis in 'xyz')
WRIST, TOOL = slice(6, 9), slice(9, 12)
WINDOW_S = 20.0


def flipped(values):
    values[:, 7] *= -1.0


def amplified(values):
    values[:, WRIST] *= 9.80665


def rotated(values):
    turn = np.linalg.qr(np.random.default_rng(SEED).standard_normal((3, 3)))[0]
    values[:, WRIST] = values[:, WRIST] @ (turn * np.linalg.det(turn))


def swapped(values):
    values[:, 6:12] = np.roll(values[:, 6:12], 3, axis=1)


@pytest.fixture
def record(structure):
    """Return a function that makes a record in which something changes at a time [s]."""

    def make(seed, change=None, at_s=0.0, columns=slice(0, 12), duration_s=60.0):
        plant = structure(FREQUENCY_HZ, DAMPING, n_channels=12, seed=SEED)
        rng = np.random.default_rng((SEED, seed))
        values = plant.simulate(rng, duration_s, RATE_HZ, 0.02).acceleration.copy()
        if change is not None:
            change(values[round(at_s * RATE_HZ) :])
        channels = tuple(Channel(name=name) for name in NAMES[columns])
        return Samples(values[:, columns], RATE_HZ, channels)

    return make


class Eyes:
    """Looks at windows as the pipeline does."""

    def __init__(self):
        self.synchronise, self.changes = Synchroniser(), SensorChanges()

    def __call__(self, samples, first_s, columns=None, pose=None):
        first = round(first_s * RATE_HZ)
        rows = samples.acceleration[first : first + round(WINDOW_S * RATE_HZ)]
        window = Samples(rows.copy(), RATE_HZ, samples.channels, round(first_s * 1e9))
        if columns is not None:
            window = window.select([NAMES[column] for column in columns])
        cleaned = self.synchronise.align(Cleaned(window, (), never, (), {}))
        return self.changes.mark(window, self.synchronise.take_peaks(), cleaned, pose)


def changed(cleaned):
    """Return the flag of each sensor that changed."""
    found = {n: f for n, f in cleaned.channel_flags.items() if f in CHANGES}
    return {Channel(name=name).sensor: flag for name, flag in found.items()}


def pose(angle_rad):
    return Pose(('joint_1',), np.array([angle_rad]), np.zeros(1))


@pytest.mark.parametrize(
    ('change', 'kind', 'who'),
    [
        (flipped, 'polarity_changed', {'wrist'}),
        (amplified, 'gain_changed', {'wrist'}),
        (rotated, 'sensor_rotated', {'wrist'}),
        (swapped, 'sensor_swapped', {'wrist', 'tool'}),
    ],
)
def test_a_sensor_that_changes_is_left_out_meanwhile_and_another_one_since(
    record, change, kind, who
):
    samples, look = record(1, change, 23.0), Eyes()
    before, within, again, after = (look(samples, first) for first in (0.0, 10.0, 20.0, 30.0))
    assert changed(before) == {} and not before.left_out
    # Where too little of a window comes after the change to tell its kind, this is said.
    flags = dict(zip(NAMES, (within.channel_flags.get(name) for name in NAMES), strict=True))
    assert {Channel(name=n).sensor for n, f in flags.items() if f} == who, f'seed {SEED}'
    assert set(flags.values()) <= {None, kind, 'shape_changed'}, f'seed {SEED}'
    assert changed(again) == dict.fromkeys(who, kind), f'seed {SEED}'
    assert {Channel(name=name).sensor for name in again.left_out} == who
    assert len(again.samples.channels) == 12 - 3 * len(who)
    assert changed(after) == dict.fromkeys(who, kind) and not after.left_out
    for channel in after.samples.channels:
        since_s = 1e-9 * channel.since_ns
        assert abs(since_s - 23.0) < 2.5 if channel.sensor in who else since_s == 0.0


def test_a_change_between_windows_that_do_not_overlap_is_seen(record):
    samples, look = record(2, swapped, 20.0), Eyes()
    assert changed(look(samples, 0.0)) == {}
    assert changed(look(samples, 20.0)) == dict.fromkeys(('wrist', 'tool'), 'sensor_swapped')


def test_sensors_that_come_back_as_each_other_are_seen(record):
    """Plugs are pulled: both are silent for a window, and then come back changed."""
    samples, look = record(3, swapped, 25.0), Eyes()
    assert changed(look(samples, 0.0)) == {}
    assert changed(look(samples, 20.0, columns=range(6))) == {}
    assert changed(look(samples, 40.0)) == dict.fromkeys(('wrist', 'tool'), 'sensor_swapped')


def test_single_channels_are_told_as_well(record):
    samples, look = record(4, flipped, 30.0, columns=slice(3, 12, 2)), Eyes()
    for first_s in (0.0, 10.0, 20.0):
        window = look(samples, first_s)
    assert {n: f for n, f in window.channel_flags.items() if f in CHANGES} == {
        'wrist.y': 'polarity_changed'
    }


def test_of_two_sensors_nobody_knows_which_one_changed(record):
    samples, look = record(5, rotated, 28.0, columns=slice(3, 9)), Eyes()
    for first_s in (0.0, 10.0, 20.0):
        window = look(samples, first_s)
    assert changed(window) == dict.fromkeys(('elbow', 'wrist'), 'sensor_changed')
    assert not set(window.left_out) & set(NAMES[3:6]) or not set(window.left_out) & set(NAMES[6:9])


def test_other_poses_are_not_compared(record):
    samples, look = record(6, rotated, 20.0), Eyes()
    look(samples, 0.0, pose=pose(0.0))
    assert changed(look(samples, 20.0, pose=pose(0.5))) == {}


def test_a_clock_that_is_set_back_forgets_what_comes_again(record):
    samples, look = record(7, amplified, 25.0), Eyes()
    for first_s in (0.0, 10.0, 20.0):
        window = look(samples, first_s)
    assert changed(window) == {'wrist': 'gain_changed'}
    assert changed(look(samples, 0.0)) == {}


def test_a_structure_that_changes_is_no_sensor_that_does(structure):
    """A payload comes: every mode has another frequency and another shape."""
    for seed in range(6):
        rng = np.random.default_rng((SEED, 100 + seed))
        plant = structure(FREQUENCY_HZ, DAMPING, n_channels=12, seed=seed)
        loaded = structure(
            np.array(FREQUENCY_HZ) * rng.uniform(0.93, 1.0, 5), DAMPING, n_channels=12, seed=seed
        )
        loaded.shapes[:] += 0.2 * rng.standard_normal((12, 5))
        values = plant.simulate(rng, 40.0, RATE_HZ, 0.02).acceleration.copy()
        values[4400:] = loaded.simulate(rng, 40.0, RATE_HZ, 0.02).acceleration[4400:]
        samples = Samples(values, RATE_HZ, tuple(Channel(name=name) for name in NAMES))
        look = Eyes()
        for first_s in (0.0, 10.0, 20.0):
            window = look(samples, first_s)
            assert changed(window) == {} and not window.since_ns, f'seed {SEED}, {seed}'


@pytest.mark.parametrize('n_axes', [1, 3])
def test_healthy_sensors_do_not_change(structure, n_axes):
    """Few and many modes, sharp and broad, close ones, and forces that go elsewhere midway."""
    for seed in range(10):
        rng = np.random.default_rng((SEED, 200 + seed, n_axes))
        n_channels, n_modes = n_axes * int(rng.integers(2, 5)), int(rng.integers(2, 8))
        hz = np.sort(rng.uniform(4.0, 80.0, n_modes))
        hz[1] = hz[0] * 1.01
        plant = structure(hz, 10 ** rng.uniform(-3.0, -1.3, n_modes), n_channels, seed)
        values = plant.simulate(rng, 40.0, RATE_HZ, 0.05).acceleration.copy()
        plant.shapes[:] *= 10 ** rng.uniform(-0.7, 0.7, n_modes)
        values[4000:] = plant.simulate(rng, 40.0, RATE_HZ, 0.05).acceleration[4000:]
        samples = Samples(values, RATE_HZ, tuple(Channel(name=n) for n in NAMES[:n_channels]))
        look = Eyes()
        for first_s in (0.0, 10.0, 20.0):
            flags = set(look(samples, first_s).channel_flags.values())
            assert not flags & {*CHANGES, 'shape_changed'}, f'seed {SEED}, {seed}'


@pytest.mark.slow
def test_nothing_is_averaged_over_a_change_and_modes_keep_their_ids(record, structure):
    """Shapes of every window are those of the sensors as they were then, or say so."""
    plant = structure(FREQUENCY_HZ, DAMPING, n_channels=12, seed=SEED)
    samples = record(8, swapped, 45.0, duration_s=70.0)
    pipeline = IdentificationPipeline(IdentificationSettings(window_s=20.0, hop_s=10.0))
    results = []
    for block in range(65):
        rows = samples.acceleration[200 * block : 200 * (block + 1)]
        pipeline.add(
            SampleBlock('/b', block * 10**9, 200 * block, RATE_HZ, NAMES, rows.astype(np.float32))
        )
        results += [pipeline.identify(window) for window in pipeline.windows()]
    results.append(pipeline.whole())
    exchanged = np.r_[0:6, 9:12, 6:9]
    for result in results:
        flags = {f for channel in result.quality.channels for f in channel.flags}
        rows = [NAMES.index(name) for name in result.modes.channel_names]
        is_after = 0 <= result.index and result.start_ns > 47.5e9
        truth = plant.shapes[exchanged if is_after else slice(None)][rows]
        spans = 0 <= result.index and not is_after and result.end_ns > 45e9
        where = f'seed {SEED}, window {result.index}'
        if 'shape_changed' in flags and spans:
            continue
        assert len(rows) == (6 if spans else 12), where
        assert ('sensor_swapped' in flags) == (result.index < 0 or result.end_ns > 45e9), where
        for mode, shape in zip(result.modes, truth.T, strict=True):
            assert mac(mode.shape, shape)[0, 0] > 0.97, where
    assert len({mode.id for result in results for mode in result.modes}) == len(FREQUENCY_HZ)


def test_diagnostics_say_since_when(record):
    samples = record(9, amplified, 24.0, duration_s=41.0)
    pipeline = IdentificationPipeline(IdentificationSettings(window_s=20.0, hop_s=10.0))
    rows = samples.acceleration.astype(np.float32)
    for first in range(0, len(rows), 200):
        pipeline.add(
            SampleBlock('/b', 5_000_000 * first, first, RATE_HZ, NAMES, rows[first : first + 200])
        )
    last = [pipeline.identify(window) for window in pipeline.windows()][-1]
    told = dict(quality_findings(last.quality))
    since_s = float(told['GAIN_CHANGED'].split()[-2])
    assert abs(since_s - 24.0) < 2.5, f'seed {SEED}: {told}'


def drifting(samples, columns, rate):
    """Return samples of which some channels have a clock that is too fast."""
    values = samples.acceleration.copy()
    at = np.arange(len(values)) * (1.0 - rate)
    values[:, columns] = interpolate(values[:, columns], at)
    return replace(samples, acceleration=values)


@pytest.mark.parametrize('rate', [3e-4, -2e-4])
@pytest.mark.parametrize('columns', [slice(0, 12), slice(6, 12)])
def test_a_clock_that_drifts_is_told_and_its_sensor_left_out(record, rate, columns):
    samples = record(11, columns=columns)
    tool = [n for n, c in enumerate(samples.channels) if c.sensor == 'tool']
    other = [n for n, c in enumerate(samples.channels) if c.sensor == samples.channels[0].sensor]
    eyes = Eyes()
    seen = drifting(samples, tool, rate)
    found = [eyes(seen, first_s) for first_s in (0.0, 20.0, 40.0)]
    flags = {n for n, flag in found[-1].channel_flags.items() if flag == 'clock_drifts'}
    # Of two sensors either may be the one.
    assert flags in ({samples.channels[n].name for n in each} for each in (tool, other))
    if len(samples.channels) > 6:
        assert flags == {samples.channels[n].name for n in tool}
    assert not flags & set(found[-1].samples.channel_names)
    steady = Eyes()
    assert not any(steady(samples, first_s).channel_flags for first_s in (0.0, 20.0, 40.0))
