"""Gain, polarity and axes of sensors on the emulated arm: nobody healthy is suspected."""

from dataclasses import replace

import numpy as np
import pytest

from modal_core.numbers.indicators import mac
from modal_core.samples import Samples
from oma_identifier.identify import identify_samples
from oma_identifier.intake import SampleBuffer
from oma_identifier.motion import RobotSignals, with_flags
from oma_identifier.motion.rigid_motion import RigidMotionRemoval
from oma_identifier.settings import IdentificationSettings

pytest.importorskip('pinocchio')
robot_files = pytest.importorskip('structural_model.robot_files')
from abb_emulator.recorder import Recorder  # noqa: E402
from test.support.shaken_arm import shaken_arm  # noqa: E402

ROBOT = 'irb6660_205_190'
SEEDS = range(41, 45)
CHECKED = {'gravity_suspicion', 'unit_g_suspicion', 'gain_suspicion', 'polarity_suspicion'} | {
    'axes_suspicion', 'rigid_motion_mismatch'
}  # fmt: skip


@pytest.fixture(scope='module')
def robot():
    return robot_files.load_robot(ROBOT)


@pytest.fixture(scope='module')
def layout():
    return robot_files.load_layout(ROBOT, 'sensors')


@pytest.fixture(scope='module')
def records(robot, layout):
    return {seed: shaken_arm(robot, layout.channels, seed) for seed in SEEDS}


def suspicions(robot, layout, joints, block, *, modelled=True):
    """Return by channel what a window of a record is suspected of."""
    buffer = SampleBuffer(IdentificationSettings(window_s=25.0), layout)
    buffer.add(joints)
    for first in range(0, len(block.acceleration), 512):
        part = block.acceleration[first : first + 512]
        stamp_ns = block.stamp_ns + round(first / block.sample_rate_hz * 1e9)
        buffer.add(replace(block, stamp_ns=stamp_ns, first_index=first, acceleration=part))
    window = next(buffer.windows())
    cleaned = RobotSignals(robot if modelled else None).clean(window)
    quality = with_flags(window.quality, cleaned)
    found = {channel.name: CHECKED.intersection(channel.flags) for channel in quality.channels}
    return {name: flags for name, flags in found.items() if flags}


@pytest.mark.slow
@pytest.mark.parametrize('modelled', [True, False])
@pytest.mark.parametrize('seed', SEEDS)
def test_a_healthy_arm_is_not_suspected(robot, layout, records, seed, modelled):
    found = suspicions(robot, layout, *records[seed], modelled=modelled)
    assert found == {}, f'seed {seed}'


@pytest.mark.slow
@pytest.mark.parametrize('seed', SEEDS)
@pytest.mark.parametrize(
    ('gain', 'flag'), [(2.0, 'gain'), (0.5, 'gain'), (9.81, 'gain'), (-1.0, 'polarity')]
)
def test_a_wrong_gain_or_sign_of_a_channel_that_gravity_drives_is_found(
    robot, layout, records, seed, gain, flag
):
    joints, block = records[seed]
    worst = int(np.argmax(np.abs(block.acceleration.mean(axis=0))))
    values = block.acceleration.copy()
    values[:, worst] *= gain
    found = suspicions(robot, layout, joints, replace(block, acceleration=values))
    name = block.channel_names[worst]
    assert f'{flag}_suspicion' in found[name], f'seed {seed}'
    sensor = {f'{name[:-1]}{axis}' for axis in 'xyz'}
    assert set(found) <= sensor, f'seed {seed}: other sensors are suspected'


@pytest.mark.parametrize('seed', SEEDS)
def test_swapped_axes_are_found(robot, layout, records, seed):
    joints, block = records[seed]
    worst = int(np.argmax(np.abs(block.acceleration.mean(axis=0))))
    first = 3 * (worst // 3)
    values = block.acceleration.copy()
    values[:, first : first + 3] = values[:, [first + 1, first + 2, first]]
    found = suspicions(robot, layout, joints, replace(block, acceleration=values))
    sensor = {block.channel_names[first + axis] for axis in range(3)}
    assert 'axes_suspicion' in set().union(*found.values()), f'seed {seed}'
    assert set(found) <= sensor, f'seed {seed}'


def test_polarity_is_told_from_motion_where_gravity_is_cut_off(robot, layout, records):
    seed = 42
    joints, block = records[seed]
    values = block.acceleration - block.acceleration.mean(axis=0)
    assert suspicions(robot, layout, joints, replace(block, acceleration=values)) == {}
    moved = [place for place, name in enumerate(block.channel_names) if 'spindle' in name]
    values[:, moved] *= -1.0
    found = suspicions(robot, layout, joints, replace(block, acceleration=values))
    assert found and {flag for flags in found.values() for flag in flags} == {'polarity_suspicion'}
    assert set(found) <= {block.channel_names[place] for place in moved}, f'seed {seed}'


def test_gyroscopes_of_a_healthy_arm_are_not_suspected_and_a_reversed_one_is(robot):
    seed = 42
    light = robot_files.load_layout(ROBOT, 'sensors_light')
    channels = Recorder.of(light).channels
    joints, block = shaken_arm(robot, channels, seed)
    samples = Samples(block.acceleration, block.sample_rate_hz, channels, block.stamp_ns)
    removed = RigidMotionRemoval(robot).remove(samples, joints)
    assert removed.fit is not None and removed.flags == {}, f'seed {seed}'
    turning = np.array([channel.unit == 'rad/s' for channel in channels])
    expected = block.acceleration - removed.samples.acceleration
    worst = int(np.argmax(np.where(turning, expected.std(axis=0), 0.0)))
    values = block.acceleration.copy()
    values[:, worst] *= -1.0
    removed = RigidMotionRemoval(robot).remove(replace(samples, acceleration=values), joints)
    assert removed.flags == {channels[worst].name: 'polarity_suspicion'}, f'seed {seed}'


def test_shapes_of_gyroscopes_are_rotations_of_the_model(robot):
    """Rotations [rad] per displacement [m], as the model's modes have them."""
    seed = 43
    light = robot_files.load_layout(ROBOT, 'sensors_light')
    channels = Recorder.of(light).channels
    joints, block = shaken_arm(robot, channels, seed, 60.0)
    samples = Samples(block.acceleration, block.sample_rate_hz, channels, block.stamp_ns)
    found = identify_samples(samples, IdentificationSettings(max_frequency_hz=70.0)).modes
    truth = robot.damped_modes(joints.position.mean(axis=0), channels)
    best = max(found, key=lambda mode: mac(mode.shape[:, None], truth.channel_shapes).max())
    like = mac(best.shape[:, None], truth.channel_shapes)[0]
    same = int(np.argmax(like))
    assert abs(best.frequency_hz / truth.frequency_hz[same] - 1.0) < 0.05, f'seed {seed}'
    assert like[same] > 0.95, f'seed {seed}: {like}'
    turning = np.array([channel.unit == 'rad/s' for channel in channels])
    # One factor for displacements and rotations alike.
    factors = [
        np.vdot(truth.channel_shapes[rows, same], best.shape[rows])
        / np.vdot(truth.channel_shapes[rows, same], truth.channel_shapes[rows, same])
        for rows in (turning, ~turning)
    ]
    assert abs(factors[0] / factors[1] - 1.0) < 0.15, f'seed {seed}: {factors}'
