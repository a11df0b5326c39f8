"""A file of columns whose robot is known: joint states beside responses, channels as laid out."""

import numpy as np
import pytest
from scipy.io import savemat

from modal_core.channel import SensorLayout
from modal_core.measurements import JointSamples
from modal_recordings import open_recording, to_mcap
from modal_recordings.of_robot import called_as_in, of_robot

JOINTS = ('joint_1', 'joint_2')
N_ROWS, RATE_HZ = 900, 100.0
RNG = np.random.default_rng(35)
ANGLES = 0.1 * RNG.standard_normal((N_ROWS, 2))
ELBOW, TOOL = RNG.standard_normal((2, N_ROWS, 3))
LAYOUT = SensorLayout.from_mapping(
    {
        'sensors': [
            {'name': 'elbow', 'frame_id': 'link_1', 'position_m': [0.0, 0.0, 0.1]},
            {'name': 'tool', 'frame_id': 'link_2', 'position_m': [0.0, 0.0, 0.1]},
        ]
    },
    'layout',
)
AXES = tuple(f'{sensor}.{axis}' for sensor in ('elbow', 'tool') for axis in 'xyz')


def text(path):
    heading = ['joint_1 [deg]', 'joint_2 [deg]', *AXES]
    rows = np.hstack([np.degrees(ANGLES), ELBOW, TOOL])
    np.savetxt(path, rows, '%.12g', ',', header=','.join(heading), comments='')


def bare_text(path):
    heading = ['q1', 'q2', *AXES]
    rows = np.hstack([ANGLES, ELBOW, TOOL])
    np.savetxt(path, rows, '%.12g', ',', header=','.join(heading), comments='')


def by_sensor(path):
    np.savez(path, q=ANGLES, elbow=ELBOW, tool=TOOL, fs=RATE_HZ)


def one_array(path):
    savemat(path, {'joint_positions': ANGLES, 'acc': np.hstack([ELBOW, TOOL]), 'fs': RATE_HZ})


@pytest.mark.parametrize(
    ('name', 'write'),
    [('a.csv', text), ('b.csv', bare_text), ('c.npz', by_sensor), ('d.mat', one_array)],
)
def test_joint_columns_are_joint_states_and_channels_those_of_the_layout(tmp_path, name, write):
    """Seed 35."""
    write(tmp_path / name)
    rate = RATE_HZ if name.endswith('csv') else None
    if name == 'a.csv':
        # Angles have their unit, responses have none.
        options = {'channels': ('joint_1 [deg]', 'joint_2 [deg]', *(f'{x} [g]' for x in AXES))}
    else:
        options = {}
    opened = open_recording(tmp_path / name, sample_rate_hz=rate, **options)
    assert any('left out' in note for note in opened.left_out)
    assert len(opened.channel_names) == 6
    assert not any(isinstance(it, JointSamples) for it in opened.measurements())
    known = called_as_in(LAYOUT, of_robot(opened, JOINTS))
    assert known.channel_names == AXES
    assert not any('q1' in note or 'joint_1' in note for note in known.left_out)
    joints = [it for it in known.measurements() if isinstance(it, JointSamples)]
    blocks = [it for it in known.measurements() if not isinstance(it, JointSamples)]
    np.testing.assert_allclose(np.concatenate([it.position for it in joints]), ANGLES, rtol=1e-9)
    assert all(np.isnan(it.velocity).all() and it.joint_names == JOINTS for it in joints)
    stamps = np.concatenate([it.stamp_ns for it in joints])
    assert np.array_equal(stamps, known.row_stamps_ns())
    values = np.concatenate([it.acceleration for it in blocks])
    scale = 9.80665 if name == 'a.csv' else 1.0
    np.testing.assert_allclose(values, scale * np.hstack([ELBOW, TOOL]), rtol=1e-9)


def test_joint_columns_are_joint_states_of_a_converted_recording_too(tmp_path):
    by_sensor(tmp_path / 'c.npz')
    known = of_robot(open_recording(tmp_path / 'c.npz', unit='m/s^2'), JOINTS)
    read = open_recording(to_mcap(known, tmp_path / 'c.mcap'))
    joints = [it for it in read.measurements() if isinstance(it, JointSamples)]
    np.testing.assert_array_equal(np.concatenate([it.position for it in joints]), ANGLES)
    assert len(read.info().channels) == 6


def test_columns_of_a_robot_with_other_joints_stay_left_out(tmp_path):
    bare_text(tmp_path / 'b.csv')
    opened = open_recording(tmp_path / 'b.csv', sample_rate_hz=RATE_HZ)
    assert of_robot(opened, ('axis_a', 'axis_b', 'axis_c')) is opened
    assert opened.channel_names == AXES


def test_a_table_of_nothing_but_joint_angles_is_one_of_responses(tmp_path):
    np.savez(tmp_path / 'q.npz', q=ANGLES, fs=RATE_HZ)
    assert len(open_recording(tmp_path / 'q.npz').channel_names) == 2


def test_a_layout_of_other_channels_is_not_taken_in_its_order_without_joints(tmp_path):
    np.savez(tmp_path / 'acc.npz', acc=np.hstack([ELBOW, TOOL]), fs=RATE_HZ)
    opened = open_recording(tmp_path / 'acc.npz')
    assert called_as_in(LAYOUT, opened).channel_names == opened.channel_names
