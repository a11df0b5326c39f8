"""Reading campaigns: what is accepted, and what is said about what is missing."""

from dataclasses import replace
import shutil

import numpy as np
import pytest
from scipy.signal import resample_poly
import yaml

from modal_core.channel import SensorLayout
from modal_core.errors import ModalAnalysisError, RecordingError, SettingsError
from modal_core.files.share import share_path
from modal_core.measurements import JointSamples, StampedSamples
from modal_recordings import RecordingWriter
from modal_recordings.messages import encode
from model_gap.campaign.campaign import GapRecord
from model_gap.campaign.campaign_file import read_campaign_file
from model_gap.campaign.read_campaign import campaign_layout, read_campaign
from model_gap.campaign.resample import at_times
from model_gap.campaign.series import gather
from model_gap.campaign.spectra import Band, record_spectra
from model_gap.effects.sensor_gain import SensorGain
from model_gap.find_gap import find_gap
from model_gap.fit.split import pose_groups, split
from model_gap.gap_json import accepted_effects
from model_gap.search.lines import common_lines
from model_gap.search.search import Search, SearchSettings
from model_gap.updated_model import write_updated_model
from structural_model import load_layout
from structural_model.robot_writer import layout_text
from test.support.hidden_campaign import make_campaign, SENSORS
from test.support.write_campaign import write_campaign

ROBOT = share_path('config', 'robots', 'irb6660_205_190')
SHORT = {'n_fit': 2, 'n_held': 1, 'duration': 6.0}


@pytest.fixture(scope='module')
def records():
    return make_campaign(ROBOT, (), 4, **SHORT)


@pytest.fixture
def folder(tmp_path, records, robot):
    write_campaign(tmp_path, records, robot.joint_names, SENSORS)
    return tmp_path


def test_motion_comes_back(folder, records, robot):
    campaign = read_campaign(folder, robot)
    assert campaign.excitation == 'joint velocities'
    assert len(campaign.records) == len(records)
    for record, truth in zip(campaign.records, records, strict=True):
        assert np.abs(record.pose - truth.pose).max() < 1e-3
        assert record.acceleration.shape[1] == 12
        assert record.heldout is truth.heldout
        rate = truth.joint_rate_hz
        times = np.arange(len(record.motor_velocity)) / record.sample_rate_hz
        told = np.column_stack(
            [
                np.interp(times, np.arange(len(truth.velocity)) / rate, column)
                for column in truth.velocity.T
            ]
        )
        inside = slice(200, -200)
        error = np.linalg.norm((record.motor_velocity - told)[inside]) / np.linalg.norm(told)
        assert error < 0.1


def test_only_the_beginning_is_read(folder, robot):
    whole, begun = (read_campaign(folder, robot, seconds=seconds) for seconds in (np.inf, 1.0))
    for record, short in zip(whole.records, begun.records, strict=True):
        count = len(short.acceleration)
        assert (
            1.0
            <= count / short.sample_rate_hz
            < 5.0
            < len(record.acceleration) / record.sample_rate_hz
        )
        # Thinned out by Fourier transform: its end is felt a little.
        inside = slice(0, round(1.0 * short.sample_rate_hz))
        apart = short.acceleration[inside] - record.acceleration[inside]
        assert np.abs(apart).max() < 1e-2 * np.abs(record.acceleration).std()


def test_recordings_without_campaign_file(folder, robot):
    (folder / 'campaign.yaml').unlink()
    campaign = read_campaign(folder, robot)
    assert len(campaign.records) == 6
    assert len({record.level for record in campaign.records}) == 2
    divided = split(campaign, np.random.default_rng(0))
    groups = pose_groups(divided)
    for group in set(groups):
        marks = {
            record.heldout
            for record, own in zip(divided.records, groups, strict=True)
            if own == group
        }
        assert len(marks) == 1, 'a pose is wholly fitted or wholly held out'
    assert {record.heldout for record in divided.records} == {True, False}


def test_a_recording_without_joint_states_is_left_out_and_named(tmp_path, records, robot):
    mute = replace(records[1], position=np.zeros((0, 6)), velocity=np.zeros((0, 6)))
    write_campaign(tmp_path, [records[0], mute], robot.joint_names, SENSORS)
    campaign = read_campaign(tmp_path, robot)
    assert len(campaign.records) == 1
    (note,) = (note for note in campaign.notes if 'left out' in note)
    assert 'no joint states' in note and 'record sensor_msgs/JointState' in note


def test_missing_joint_states_are_named(tmp_path, records, robot):
    empty = [replace(records[0], position=np.zeros((0, 6)), velocity=np.zeros((0, 6)))]
    write_campaign(tmp_path, empty, robot.joint_names, SENSORS)
    with pytest.raises(RecordingError, match='joint states'):
        read_campaign(tmp_path, robot)


def test_other_robot_is_refused(tmp_path, records, robot):
    write_campaign(tmp_path, records[:1], ('a', 'b', 'c', 'd', 'e', 'f'), SENSORS)
    with pytest.raises(RecordingError, match='another robot'):
        read_campaign(tmp_path, robot)


def test_sensors_count_where_they_were_recorded(tmp_path, records, robot):
    write_campaign(tmp_path / 'all', records[:1], robot.joint_names, SENSORS)
    fewer = [replace(records[1], acceleration=records[1].acceleration[:, :9])]
    write_campaign(tmp_path / 'few', fewer, robot.joint_names, SENSORS[:3])
    layout = yaml.safe_load((tmp_path / 'all' / 'sensors.yaml').read_text())
    entries = [{'file': 'all/p0_l0.mcap'}, {'file': 'few/p0_l1.mcap'}]
    (tmp_path / 'campaign.yaml').write_text(
        yaml.safe_dump({'recordings': entries, 'sensors': layout['sensors']})
    )
    campaign = read_campaign(tmp_path, robot)
    assert len(campaign.layout.channels) == 12
    assert [record.missing for record in campaign.records] == [(), (9, 10, 11)]
    assert any('not in every recording' in note for note in campaign.notes)


def test_recordings_of_one_name_in_different_folders_are_told_apart(tmp_path, records, robot):
    same = [replace(record, name='loud') for record in records[:2]]
    for name, record in zip(('monday', 'tuesday'), same, strict=True):
        write_campaign(tmp_path / name, [record], robot.joint_names, SENSORS)
    layout = yaml.safe_load((tmp_path / 'monday' / 'sensors.yaml').read_text())
    entries = ['monday/loud.mcap', {'file': './tuesday/loud.mcap'}]
    (tmp_path / 'campaign.yaml').write_text(yaml.safe_dump({'recordings': entries, **layout}))
    campaign = read_campaign(tmp_path, robot)
    assert [item.name for item in campaign.records] == ['monday/loud.mcap', 'tuesday/loud.mcap']


@pytest.mark.parametrize(
    ('text', 'told'),
    [
        ('recordings: []', 'no recordings'),
        ('recordings: [{level: 1}]', 'file missing'),
        ('recordings: [{file: nowhere.mcap}]', 'file missing'),
        ('recordings: [7]', 'not a mapping'),
        ('recordings: [{file: p0_l0.mcap, pose: [a]}]', 'bad pose'),
        ('recordings: [{file: p0_l0.mcap, heldout: maybe}]', 'not true or false'),
        ('nothing: here', 'no recordings'),
    ],
)
def test_bad_campaign_file_is_one_clear_line(folder, text, told):
    (folder / 'campaign.yaml').write_text(text)
    with pytest.raises(SettingsError, match=told) as caught:
        read_campaign_file(folder)
    assert '\n' not in str(caught.value)


def test_missing_folder(tmp_path, robot):
    with pytest.raises(ModalAnalysisError, match='not a folder'):
        read_campaign(tmp_path / 'nowhere', robot)


def test_per_sample_messages_find_their_sensor(layout, rng):
    stamps = 10**18 + np.arange(0, 4000) * 4_000_000
    values = rng.standard_normal((4000, 3))
    measurements = [
        StampedSamples('/accel/elbow', 'link_3', stamps, values),
        JointSamples(stamps, ('a', 'b'), np.zeros((4000, 2)), np.full((4000, 2), np.nan)),
    ]
    raw = gather(measurements, layout, 'test')
    assert raw.accelerations[0].names == ('elbow.x', 'elbow.y', 'elbow.z')
    assert raw.accelerations[0].rate_hz == pytest.approx(250.0)
    assert raw.velocity is None
    assert raw.position is not None


@pytest.mark.parametrize('order', [0, 1, 2])
def test_resampling_and_derivatives_against_sines(order):
    rate, frequencies = 250.0, np.array([4.0, 17.0, 45.0])
    time = np.arange(1500) / rate
    values = np.sin(2 * np.pi * time[:, None] * frequencies)
    wanted = 0.7 + np.arange(2000) * 0.002113
    omega = 2 * np.pi * frequencies
    exact = omega**order * np.sin(wanted[:, None] * omega + order * np.pi / 2)
    found = at_times(values, rate, wanted, order)
    assert np.abs(found - exact).max() < 0.01 * np.abs(exact).max()


def test_robots_prefix_and_other_joints_do_not_matter(tmp_path, records, robot):
    names = tuple(f'cell/{name}' for name in robot.joint_names)
    more = [
        replace(
            records[0],
            position=np.column_stack([records[0].position, np.zeros(len(records[0].position))]),
            velocity=np.column_stack([records[0].velocity, np.zeros(len(records[0].velocity))]),
        )
    ]
    write_campaign(tmp_path, more, (*names, 'gripper'), SENSORS)
    campaign = read_campaign(tmp_path, robot)
    assert np.abs(campaign.records[0].pose - records[0].pose).max() < 1e-3


def test_holes_are_cut_out_and_dead_channels_left_out(tmp_path, records, robot):
    spoilt = records[0].acceleration.copy()
    spoilt[: len(spoilt) // 5] = np.nan
    spoilt[:, 4] = np.nan
    write_campaign(
        tmp_path, [replace(records[0], acceleration=spoilt)], robot.joint_names, SENSORS
    )
    campaign = read_campaign(tmp_path, robot)
    (record,) = campaign.records
    assert np.isfinite(record.acceleration).all()
    assert record.acceleration.shape[1] == 11
    assert len(record.acceleration) / record.sample_rate_hz == pytest.approx(4.8, abs=0.1)
    assert any('mostly not a number' in note for note in campaign.notes)


def test_a_sensor_with_sensitivity_may_lose_an_axis(tmp_path, records, robot, layout):
    frame, *others = layout
    mixed = replace(frame, sensitivity=((0.0, 1.0, 0.0), (1.1, 0.0, 0.0), (0.0, 0.0, -1.0)))
    spoilt = records[0].acceleration.copy()
    spoilt[:, 0] = np.nan
    write_campaign(
        tmp_path, [replace(records[0], acceleration=spoilt)], robot.joint_names, SENSORS
    )
    campaign = read_campaign(tmp_path, robot, SensorLayout((mixed, *others)))
    channels = [channel for channel in campaign.layout.channels if channel.name[:5] == 'frame']
    assert [(item.name, item.direction) for item in channels] == [
        ('frame.y', (1.1, 0.0, 0.0)),
        ('frame.z', (0.0, 0.0, -1.0)),
    ]


def test_a_channel_that_never_changes_is_left_out(tmp_path, records, robot):
    spoilt = records[0].acceleration.copy()
    spoilt[:, 4], spoilt[:, 7] = 0.0, 9.81
    write_campaign(
        tmp_path, [replace(records[0], acceleration=spoilt)], robot.joint_names, SENSORS
    )
    campaign = read_campaign(tmp_path, robot)
    assert len(campaign.layout.channels) == 10
    assert (campaign.records[0].acceleration.std(axis=0) > 0.0).all()
    (note,) = (note for note in campaign.notes if 'always the same number' in note)
    assert 'lower_arm.y, elbow.y' in note


def sampled_at(rate_hz, record):
    """Return a record of slower sensors with a filter before them."""
    slower = resample_poly(record.acceleration, rate_hz, round(record.rate_hz), padtype='line')
    return replace(record, acceleration=slower, rate_hz=float(rate_hz))


@pytest.mark.parametrize(('rate_hz', 'high_hz'), [(100, 45.0), (120, 54.0), (250, 60.0)])
def test_slow_sensors_are_compared_as_far_as_they_tell(tmp_path, records, robot, rate_hz, high_hz):
    slow = [sampled_at(rate_hz, record) for record in records[:2]]
    write_campaign(tmp_path, slow, robot.joint_names, SENSORS)
    campaign = read_campaign(tmp_path, robot)
    told = [note for note in campaign.notes if f'compared up to {high_hz:g} Hz' in note]
    assert bool(told) == (rate_hz < 133), campaign.notes
    assert any('small gap' in note for note in campaign.notes) == (rate_hz < 150)
    assert not any('joint states limit' in note for note in campaign.notes)
    lines = (20.0, 49.4, 59.9)
    for record in campaign.records:
        item = record_spectra(record, Band(), lines_hz=lines)
        assert np.isfinite(item.measured).all()
        assert np.diff(item.omega, axis=1).min() > 0.0, 'every bin has its neighbours'
        plain = record_spectra(record, Band()).frequency_hz
        assert plain[-1] == pytest.approx(high_hz, abs=0.4)
    search = Search.begin(robot, campaign, simulated=True)
    assert (
        search.data.fitting.weighting.misfit(search.data.fitting.rows(search.nominal.cell()))
        < 200.0
    )


def test_a_line_at_the_edge_of_slow_sensors_is_no_line_beyond(rng):
    rate_hz, count, line_hz = 100.0, 3000, 49.9
    hum = 20.0 * np.sin(2.0 * np.pi * line_hz * np.arange(count) / rate_hz)
    response, motion = rng.standard_normal((count, 3)), rng.standard_normal((count, 2))
    record = GapRecord(
        'hum', np.zeros(2), '1', rate_hz, response + hum[:, None], motion, motion, motion
    )
    assert common_lines([record], Band()) == pytest.approx((line_hz,), abs=0.01)


def test_sensors_too_slow_for_anything_are_one_clear_line(tmp_path, records, robot):
    slow = [sampled_at(10, record) for record in records[:1]]
    write_campaign(tmp_path, slow, robot.joint_names, SENSORS)
    with pytest.raises(RecordingError, match='too slow') as caught:
        read_campaign(tmp_path, robot)
    assert 'p0_l0.mcap' in str(caught.value) and '13.3 Hz' in str(caught.value)


@pytest.mark.parametrize(
    ('change', 'told'),
    [
        (lambda r: replace(r, position=np.rad2deg(r.position) + 400.0), 'radians'),
        (lambda r: replace(r, position=np.full_like(r.position, np.nan)), 'no joint states'),
        (lambda r: replace(r, acceleration=np.full_like(r.acceleration, np.nan)), 'no accel'),
        (lambda r: replace(r, acceleration=np.ones_like(r.acceleration)), 'always the same'),
        (
            lambda r: replace(
                r, acceleration=r.acceleration[:900], position=r.position[:450],
                velocity=r.velocity[:450],
            ),
            'too short',
        ),
        (lambda r: replace(r, acceleration=r.acceleration[:7]), 'too short|no accel'),
    ],
)  # fmt: skip
def test_what_cannot_be_used_is_one_clear_line(tmp_path, records, robot, change, told):
    write_campaign(tmp_path, [change(records[0])], robot.joint_names, SENSORS)
    with pytest.raises(ModalAnalysisError, match=told) as caught:
        read_campaign(tmp_path, robot)
    assert '\n' not in str(caught.value)


@pytest.mark.parametrize(
    ('change', 'told'),
    [
        (lambda r: replace(r, position=np.rad2deg(r.position) + 400.0), 'radians'),
        (lambda r: replace(r, acceleration=r.acceleration[:900]), 'too short'),
    ],
)
def test_one_bad_recording_does_not_end_a_campaign(tmp_path, records, robot, change, told):
    bad = change(records[0])
    write_campaign(tmp_path, [bad, records[1]], robot.joint_names, SENSORS)
    campaign = read_campaign(tmp_path, robot)
    assert [item.name for item in campaign.records] == ['p0_l1.mcap']
    (note,) = (note for note in campaign.notes if 'left out' in note)
    assert told in note and 'p0_l0.mcap' in note


def test_sensors_and_joints_on_different_clocks(tmp_path, records, robot, layout):
    measured = [
        StampedSamples(
            f'/accel/{sensor.name}',
            sensor.frame_id,
            np.arange(3000) * 2_000_000,
            records[0].acceleration[:, 3 * number : 3 * number + 3],
        )
        for number, sensor in enumerate(layout)
    ]
    stamps = 10**18 + np.arange(len(records[0].position)) * 4_000_000
    joints = JointSamples(stamps, robot.joint_names, records[0].position, records[0].velocity)
    with RecordingWriter(tmp_path / 'a.mcap') as writer:
        for item in (*measured, joints):
            topic = item.source if isinstance(item, StampedSamples) else '/joint_states'
            for message in encode(item, topic):
                writer.write(
                    message.topic, message.message_type, message.log_time_ns, message.data
                )
    with pytest.raises(RecordingError, match='one clock'):
        read_campaign(tmp_path, robot, layout)


def test_single_samples_at_another_rate_that_start_later(tmp_path, records, robot, layout, rng):
    """Imu-like messages at 400 Hz with jittered stamps and losses, joints from 0.3 s before."""
    record = records[0]
    seconds = np.arange(round(5.4 * 400.0)) / 400.0 + 0.3
    source = np.arange(len(record.acceleration)) / record.rate_hz
    kept = np.sort(rng.choice(len(seconds), len(seconds) - 5, replace=False))
    late = rng.uniform(0.0, 4e-4, len(kept))
    start = 10**18
    with RecordingWriter(tmp_path / 'a.mcap') as writer:
        for number, sensor in enumerate(layout):
            values = np.column_stack(
                [
                    np.interp(seconds, source, column)
                    for column in record.acceleration[:, 3 * number : 3 * number + 3].T
                ]
            )
            stamps = start + np.rint((seconds[kept] + late) * 1e9).astype(np.int64)
            samples = StampedSamples(f'/accel/{sensor.name}', '', stamps, values[kept])
            for message in encode(samples, samples.source):
                writer.write(
                    message.topic, message.message_type, message.log_time_ns, message.data
                )
        times = start + np.rint(np.arange(len(record.position)) / 250.0 * 1e9).astype(np.int64)
        joints = JointSamples(times, robot.joint_names, record.position, record.velocity)
        for message in encode(joints, '/joint_states'):
            writer.write(message.topic, message.message_type, message.log_time_ns, message.data)
    (found,) = read_campaign(tmp_path, robot, layout).records
    assert found.sample_rate_hz == pytest.approx(400.0, rel=1e-4)
    truth = np.interp(
        0.3 + np.arange(len(found.motor_velocity)) / 400.0,
        np.arange(len(record.velocity)) / 250.0,
        record.velocity[:, 1],
    )
    inside = slice(200, -200)
    error = np.std((found.motor_velocity[:, 1] - truth)[inside]) / np.std(truth)
    assert error < 0.1


def test_remarks_are_kept_and_a_file_named_twice_is_refused(folder, robot):
    content = yaml.safe_load((folder / 'campaign.yaml').read_text())
    content['notes'] = 'new gearbox'
    content['recordings'][0]['notes'] = ['door open']
    (folder / 'campaign.yaml').write_text(yaml.safe_dump(content))
    assert read_campaign_file(folder).remarks == ('new gearbox', 'p0_l0.mcap: door open')
    content['recordings'].append({'file': 'p0_l0.mcap'})
    (folder / 'campaign.yaml').write_text(yaml.safe_dump(content))
    with pytest.raises(SettingsError, match='twice'):
        read_campaign_file(folder)


def test_a_copy_under_another_name_is_refused_and_both_are_named(folder, robot):
    (folder / 'campaign.yaml').unlink()
    shutil.copy(folder / 'p0_l1.mcap', folder / 'p7_l1.mcap')
    with pytest.raises(RecordingError) as caught:
        read_campaign(folder, robot)
    assert 'same samples (found p0_l1.mcap and p7_l1.mcap' in str(caught.value)


def test_another_pose_than_said_is_noted(folder, robot):
    content = yaml.safe_load((folder / 'campaign.yaml').read_text())
    content['recordings'][0]['pose'] = [0.0] * 6
    (folder / 'campaign.yaml').write_text(yaml.safe_dump(content))
    assert any('away from the pose' in note for note in read_campaign(folder, robot).notes)


@pytest.mark.slow
def test_the_corrected_layout_keeps_what_was_left_out(tmp_path, robot, layout):
    """One axis of the faulty sensor and the whole of another are dead in all recordings."""
    hidden = [{'type': 'sensor_gain', 'sensor': 'elbow', 'axis': None, 'gain': 1.4}]
    records = make_campaign(ROBOT, hidden, 8, n_fit=2, n_held=1, duration=6.0)
    for record in records:
        record.acceleration[:, [0, 1, 2, 6]] = np.nan
    write_campaign(tmp_path, records, robot.joint_names, SENSORS)
    campaign = read_campaign(tmp_path, robot)
    assert len(campaign.layout.channels) == 8
    result = find_gap(robot, campaign, SearchSettings(catalogue=(SensorGain,), most_effects=1))
    (found,) = accepted_effects(result)
    assert found.location == 'sensor:elbow', 'seed 8'
    path = write_updated_model(result, tmp_path / 'out')
    new = load_layout(path)
    assert [item.name for item in new.channels] == [item.name for item in layout.channels]
    size = {item.name: np.linalg.norm(item.direction) for item in new.channels}
    gain = found.parameters[0].value
    assert gain == pytest.approx(1.4, rel=0.05)
    for axis in 'yz' if not found.variant else found.variant:
        assert size[f'elbow.{axis}'] == pytest.approx(gain, rel=0.04), 'and its tolerance'
    assert all(size[f'frame.{axis}'] == pytest.approx(1.0) for axis in 'xyz'), 'not recorded'
    assert 'elbow' in (tmp_path / 'out' / 'model_updated.diff').read_text()


def test_a_layout_that_recordings_carry_is_taken_where_the_campaign_states_none(tmp_path, layout):
    """Of the first that carries one; a file sensors.yaml beside them counts before it."""
    own = replace(layout.sensors[0], name='my_own', position_m=(0.1, 0.2, 0.3))
    joints = JointSamples(np.arange(2), ('a',), np.zeros((2, 1)), np.zeros((2, 1)))
    files = {'c.mcap': {'sensors.yaml': layout_text(SensorLayout((own,))).encode()}, 'b.mcap': {}}
    for name, attached in files.items():
        with RecordingWriter(tmp_path / name, attached=attached) as writer:
            for message in encode(joints, '/joint_states'):
                writer.write(
                    message.topic, message.message_type, message.log_time_ns, message.data
                )
    (tmp_path / 'a.mcap').write_bytes(b'not MCAP')
    assert campaign_layout(tmp_path, str(ROBOT)).sensors == (own,)
    assert campaign_layout(tmp_path, None).sensors == (own,)
    (tmp_path / 'c.mcap').unlink()
    assert campaign_layout(tmp_path, str(ROBOT)).sensors == load_layout(ROBOT).sensors
    assert campaign_layout(tmp_path, None) is None
    (tmp_path / 'sensors.yaml').write_text(layout_text(layout))
    assert campaign_layout(tmp_path, str(ROBOT)) is None
