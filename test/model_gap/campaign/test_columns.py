"""Campaigns of plain files: joint angles are columns beside the accelerations, or files beside."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.io import savemat
import yaml

from modal_core.errors import ModalAnalysisError, RecordingError, SettingsError
from modal_core.files.share import share_path
from model_gap.campaign.read_campaign import read_campaign
from test.support.hidden_campaign import make_campaign, SENSORS
from test.support.write_campaign import write_campaign

ROBOT = share_path('config', 'robots', 'irb6660_205_190')
CHANNELS = [f'{name}.{axis}' for name, _, _ in SENSORS for axis in 'xyz']
LAYOUT = [{'name': n, 'frame_id': link, 'position_m': list(p)} for n, link, p in SENSORS]
JOINTS = [f'joint_{n}' for n in range(1, 7)]


@pytest.fixture(scope='module')
def record():
    """Return one recording, seed 4."""
    return make_campaign(ROBOT, (), 4, n_fit=1, n_held=1, duration=6.0)[0]


@pytest.fixture
def plain(tmp_path, record, robot):
    """What the same recording is in MCAP."""
    write_campaign(tmp_path / 'mcap', [record], robot.joint_names, SENSORS)
    return read_campaign(tmp_path / 'mcap', robot)


def campaign(tmp_path, stated=None, entries=None):
    """Return the folder of plain files with its layout; with campaign.yaml where entries are."""
    folder = tmp_path / 'plain'
    folder.mkdir(exist_ok=True)
    (folder / 'sensors.yaml').write_text(yaml.safe_dump({'sensors': LAYOUT}))
    if entries is not None:
        told = {'recordings': entries, **(stated or {})}
        (folder / 'campaign.yaml').write_text(yaml.safe_dump(told))
    return folder


def seconds(record):
    """Return times of accelerations and of joint states [s]."""
    return (
        np.arange(len(record.acceleration)) / record.rate_hz,
        np.arange(len(record.position)) / record.joint_rate_hz,
    )


def on_sensors(record, values):
    """Return joint values at the times of the accelerations; they are smooth."""
    times, joint_times = seconds(record)
    return CubicSpline(joint_times, values, axis=0)(np.minimum(times, joint_times[-1]))


def write_text(path, headings, columns, separator=','):
    lines = [separator.join(headings)]
    lines += [separator.join(f'{value:.9g}' for value in row) for row in np.column_stack(columns)]
    path.write_text('\n'.join(lines) + '\n')


def check(found, plain, motion=0.02):
    """Hold a campaign against the one of MCAP."""
    (one,), (other,) = found.records, plain.records
    inside = slice(200, min(len(one.acceleration), len(other.acceleration)) - 200)
    # MCAP keeps four bytes a value.
    assert np.allclose(one.acceleration[inside], other.acceleration[inside], atol=1e-4)
    assert np.abs(one.pose - other.pose).max() < 1e-4
    told, right = one.motor_velocity[inside], other.motor_velocity[inside]
    assert np.linalg.norm(told - right) < motion * np.linalg.norm(right)


WORDINGS = {
    'names': (JOINTS, None, 1.0),
    'degrees': ([f'{name} [deg]' for name in JOINTS], None, 180.0 / np.pi),
    'counted from one': ([f'q{n}' for n in range(1, 7)], [f'dq{n}' for n in range(1, 7)], 1.0),
    'counted from zero': ([f'theta[{n}]' for n in range(6)], None, 1.0),
    'said in words': (
        [f'{name}_position' for name in JOINTS],
        [f'{name}_velocity [rad/s]' for name in JOINTS],
        1.0,
    ),
    'robot before': ([f'left/{name}' for name in JOINTS], None, 1.0),
    'suffix': ([f'J{n}_deg' for n in range(1, 7)], None, 180.0 / np.pi),
}


@pytest.mark.parametrize('wording', WORDINGS)
def test_columns_of_a_text_are_joints_however_they_are_called(
    tmp_path, record, robot, plain, wording
):
    angles, speeds, factor = WORDINGS[wording]
    folder = campaign(tmp_path)
    columns = [seconds(record)[0], factor * on_sensors(record, record.position)]
    headings = ['time [s]', *angles]
    if speeds:
        columns.append(on_sensors(record, record.velocity))
        headings += speeds
    write_text(folder / 'a.csv', [*headings, *CHANNELS], [*columns, record.acceleration])
    found = read_campaign(folder, robot)
    check(found, plain)
    assert found.excitation == ('joint velocities' if speeds else 'joint positions')


@pytest.mark.parametrize('units', ['m/s^2', 'g'])
def test_torques_are_known_and_units_of_headings_count(tmp_path, record, robot, plain, units):
    folder = campaign(tmp_path)
    positions = on_sensors(record, record.position)
    headings = [
        't [s]',
        *(f'{name} [rad]' for name in JOINTS),
        *(f'tau{n} [Nm]' for n in range(6)),
    ]
    headings += [f'{name} [{units}]' for name in CHANNELS]
    scaled = record.acceleration / (9.80665 if units == 'g' else 1.0)
    columns = [seconds(record)[0], positions, np.sin(positions), scaled]
    write_text(folder / 'a.csv', headings, columns)
    found = read_campaign(folder, robot)
    check(found, plain)
    assert found.effort_recorded


def arrays(record):
    """Return arrays by name, each sensor one."""
    sensors = {
        name: record.acceleration[:, 3 * n : 3 * n + 3] for n, (name, _, _) in enumerate(SENSORS)
    }
    times, joint_times = seconds(record)
    return {'t': times, **sensors}, {'t_q': joint_times, 'q': record.position}


def test_arrays_of_two_rates_have_a_time_each(tmp_path, record, robot, plain):
    folder = campaign(tmp_path)
    sensors, joints = arrays(record)
    np.savez(folder / 'a.npz', **sensors, **joints)
    check(read_campaign(folder, robot), plain)
    del joints['t_q']
    np.savez(folder / 'a.npz', **sensors, **joints)
    with pytest.raises(RecordingError, match=r'not a time of each.*t_joints'):
        read_campaign(folder, robot)


def test_arrays_without_names_are_in_the_order_of_the_layout(tmp_path, record, robot, plain):
    folder = campaign(tmp_path)
    matrix = {
        'fs': record.rate_hz,
        'q': on_sensors(record, record.position),
        'acc': record.acceleration,
    }
    savemat(folder / 'a.mat', matrix)
    found = read_campaign(folder, robot)
    check(found, plain)
    assert any('taken in its order' in note for note in found.notes)
    # What is said of several recordings is said once.
    rng = np.random.default_rng(4)
    for name in ('b.mat', 'c.mat'):
        other = record.acceleration + 0.01 * rng.standard_normal(record.acceleration.shape)
        savemat(folder / name, {**matrix, 'acc': other})
    (note,) = (it for it in read_campaign(folder, robot).notes if 'taken in its order' in it)
    assert note.startswith('a.mat and 2 more: ')
    for name in ('b.mat', 'c.mat'):
        (folder / name).unlink()
    savemat(folder / 'a.mat', {**matrix, 'acc': record.acceleration[:, :5]})
    with pytest.raises(RecordingError, match='no acceleration of the sensor layout'):
        read_campaign(folder, robot)


@pytest.mark.parametrize('kind', ['csv', 'mcap'])
def test_joint_states_may_be_in_a_file_of_their_own(tmp_path, record, robot, plain, kind):
    folder = campaign(tmp_path, entries=[{'file': f'a.{kind}', 'joints': 'a_joints.csv'}])
    times, joint_times = seconds(record)
    start_s = 0.0
    if kind == 'csv':
        write_text(folder / 'a.csv', ['time [s]', *CHANNELS], [times, record.acceleration])
    else:
        start_s = 1.7e9
        mute = replace(record, position=np.zeros((0, 6)), velocity=np.zeros((0, 6)))
        write_campaign(tmp_path / 'mute', [mute], robot.joint_names, SENSORS)
        next((tmp_path / 'mute').glob('*.mcap')).rename(folder / 'a.mcap')
    stamps = [f'{start_s + time:.6f}' for time in joint_times]
    rows = [
        ','.join([stamp, *(f'{angle:.9g}' for angle in row)])
        for stamp, row in zip(stamps, record.position, strict=True)
    ]
    (folder / 'a_joints.csv').write_text('\n'.join([','.join(['time [s]', *JOINTS]), *rows]))
    check(read_campaign(folder, robot), plain)


def test_campaign_yaml_says_what_files_do_not(tmp_path, record, robot, plain):
    stated = {
        'sample_rate_hz': record.rate_hz,
        'channels': [*(f'q{n}' for n in range(1, 7)), '-', *CHANNELS],
    }
    folder = campaign(tmp_path, stated, entries=['a.npy'])
    positions = on_sensors(record, record.position)
    rubbish = np.random.default_rng(1).normal(size=len(positions))
    np.save(folder / 'a.npy', np.column_stack([positions, rubbish, record.acceleration]))
    check(read_campaign(folder, robot), plain)
    campaign(tmp_path, {**stated, 'sample_rate_hz': -1}, entries=['a.npy'])
    with pytest.raises(RecordingError, match='bad rate'):
        read_campaign(folder, robot)
    campaign(tmp_path, {'sample_rate_hz': 500}, entries=['a.mcap'])
    write_campaign(tmp_path / 'other', [record], robot.joint_names, SENSORS)
    next((tmp_path / 'other').glob('*.mcap')).rename(folder / 'a.mcap')
    with pytest.raises(SettingsError, match='stated by the recording itself'):
        read_campaign(folder, robot)


@pytest.mark.parametrize(
    ('headings', 'message'),
    [
        ([f'r{n}' for n in range(1, 7)], 'no joint angles.*joint_1.*q1.*joints: FILE'),
        ([f'q{n}' for n in (1, 2, 3, 4, 5, 7)], 'no joint angles'),
        ([f'q{n} [s]' for n in range(1, 7)], 'which of the times'),
    ],
)
def test_what_lacks_angles_says_how_they_are_called(tmp_path, record, robot, headings, message):
    folder = campaign(tmp_path)
    columns = [seconds(record)[0], on_sensors(record, record.position), record.acceleration]
    write_text(folder / 'a.csv', ['time [s]', *headings, *CHANNELS], columns)
    with pytest.raises(ModalAnalysisError, match=message):
        read_campaign(folder, robot)


def test_two_sets_of_angles_are_asked_about(tmp_path, record, robot):
    folder = campaign(tmp_path)
    positions = on_sensors(record, record.position)
    headings = ['time [s]', *JOINTS, *(f'q{n}' for n in range(1, 7)), *CHANNELS]
    columns = [seconds(record)[0], positions, positions, record.acceleration]
    write_text(folder / 'a.csv', headings, columns)
    with pytest.raises(RecordingError, match=r'two columns tell the position.*leave it out'):
        read_campaign(folder, robot)


def test_tables_beside_bags_are_no_recordings(tmp_path, record, robot):
    folder = campaign(tmp_path)
    write_campaign(folder, [record], robot.joint_names, SENSORS)
    (folder / 'campaign.yaml').unlink()
    (folder / 'planned.csv').write_text('pose,level\n1,2\n')
    found = read_campaign(folder, robot)
    assert len(found.records) == 1 and not any('planned' in note for note in found.notes)
