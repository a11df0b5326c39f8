"""Gain, polarity and axes of sensors on the emulated arm: nobody healthy is suspected."""

from dataclasses import replace

import numpy as np
import pytest

from oma_identifier.intake import SampleBuffer
from oma_identifier.motion import RobotSignals, with_flags
from oma_identifier.settings import IdentificationSettings

pytest.importorskip('pinocchio')
robot_files = pytest.importorskip('structural_model.robot_files')
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


@pytest.mark.parametrize('modelled', [True, False])
@pytest.mark.parametrize('seed', SEEDS)
def test_a_healthy_arm_is_not_suspected(robot, layout, records, seed, modelled):
    found = suspicions(robot, layout, *records[seed], modelled=modelled)
    assert found == {}, f'seed {seed}'


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
