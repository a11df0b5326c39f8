"""Recordings in and out: what is written comes back; damaged files say what was lost."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rosbags.highlevel import AnyReader
from rosbags.rosbag1 import Writer as Rosbag1Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Rosbag2Writer
from rosbags.typesys import get_typestore, Stores

from autonomous_modal_analysis.identified.identification import identify_recording
from modal_core.errors import IdentificationError, MessageError, RecordingError
from modal_core.measurements import JointSamples, SampleBlock, StampedSamples
from modal_recordings import decode, open_recording, RecordingWriter, to_mcap
from modal_recordings.messages import ACCEL, BLOCK, definition, encode, IMU, JOINT_STATE, typestore
from oma_identifier.settings import IdentificationSettings

START = 1_700_000_000_123_456_789
SEED = 3


def imu_samples(n=500, frame_id='elbow_link'):
    rng = np.random.default_rng(SEED)
    stamps = START + np.arange(n, dtype=np.int64) * 1_000_000
    return StampedSamples(
        '/imu/elbow', frame_id, stamps, rng.normal(size=(n, 3)), rng.normal(size=(n, 3))
    )


def blocks(n=40, rows=32, n_channels=6, rate=1024.0):
    rng = np.random.default_rng(SEED)
    names = tuple(f'a{i}' for i in range(n_channels))
    return [
        SampleBlock(
            '/acceleration_block',
            START + round(i * rows * 1e9 / rate),
            i * rows,
            rate,
            names,
            rng.normal(size=(rows, n_channels)).astype(np.float32),
        )
        for i in range(n)
    ]


def messages(n=500):
    found = encode(imu_samples(n), '/imu/elbow')
    for block in blocks():
        found += encode(block, '/acceleration_block')
    joints = JointSamples(
        START + np.arange(20, dtype=np.int64) * 20_000_000,
        ('j1', 'j2'),
        np.linspace(0, 1, 40).reshape(20, 2),
        np.full((20, 2), np.nan),
    )
    found += encode(joints, '/joint_states')
    return sorted(found, key=lambda message: message.log_time_ns)


@pytest.fixture
def mcap(tmp_path):
    path = tmp_path / 'a.mcap'
    with RecordingWriter(path) as writer:
        for m in messages():
            writer.write(m.topic, m.message_type, m.log_time_ns, m.data)
    return path


def gathered(path, **options):
    imu, block, joints = [], [], []
    recording = open_recording(path, **options)
    for measurement in recording.measurements():
        kinds = {StampedSamples: imu, SampleBlock: block, JointSamples: joints}
        kinds[type(measurement)].append(measurement)
    return recording, imu, block, joints


def check_content(path):
    _, imu, block, joints = gathered(path)
    truth = imu_samples()
    assert np.array_equal(np.concatenate([part.stamp_ns for part in imu]), truth.stamp_ns)
    assert np.array_equal(np.concatenate([p.acceleration for p in imu]), truth.acceleration)
    turn = np.concatenate([part.angular_velocity for part in imu])
    assert np.array_equal(turn, truth.angular_velocity)
    assert imu[0].frame_id == 'elbow_link'
    if block:
        for found, sent in zip(block, blocks(), strict=True):
            assert np.array_equal(found.acceleration, sent.acceleration)
            assert (found.stamp_ns, found.first_index) == (sent.stamp_ns, sent.first_index)
            assert found.channel_names == sent.channel_names
    assert sum(len(part.stamp_ns) for part in joints) == 20
    assert joints[0].joint_names == ('j1', 'j2')


def test_mcap_round_trip_is_exact(mcap):
    check_content(mcap)
    info = open_recording(mcap).info()
    assert info.damage == ()
    assert [topic.usable for topic in info.topics] == [True, True, True]
    assert {topic.name: topic.n_messages for topic in info.topics} == {
        '/acceleration_block': 40,
        '/imu/elbow': 500,
        '/joint_states': 20,
    }


def test_a_file_written_topic_after_topic_is_read_by_log_time(tmp_path):
    path = tmp_path / 'topics.mcap'
    sent = messages(3000)
    with RecordingWriter(path) as writer:
        for number, m in enumerate(sorted(sent, key=lambda message: message.topic)):
            writer.write(m.topic, m.message_type, m.log_time_ns, m.data)
            if number % 400 == 399:
                writer.flush()
    file = open_recording(path).file
    found = list(file.messages())
    assert [m.log_time_ns for m in found] == [m.log_time_ns for m in sent]
    assert sorted(m.data for m in found) == sorted(m.data for m in sent)
    assert not file.damage()
    only = list(file.messages(frozenset({'/joint_states'})))
    assert [m.log_time_ns for m in only] == sorted(m.log_time_ns for m in only)
    assert len(only) == 20


def test_rosbags_reads_what_we_write_and_agrees_on_every_field(mcap):
    with AnyReader([mcap]) as reader:
        values = [
            reader.deserialize(raw, connection.msgtype)
            for connection, _, raw in reader.messages()
            if connection.msgtype == IMU
        ]
    truth = imu_samples()
    assert [v.linear_acceleration.y for v in values] == truth.acceleration[:, 1].tolist()
    assert [v.angular_velocity.z for v in values] == truth.angular_velocity[:, 2].tolist()
    assert values[0].header.frame_id == 'elbow_link'


@pytest.mark.parametrize('plugin', [StoragePlugin.SQLITE3, StoragePlugin.MCAP])
@pytest.mark.parametrize('bare', [False, True])
def test_rosbag2_folders_and_bare_files(tmp_path, plugin, bare):
    folder = tmp_path / 'bag'
    with Rosbag2Writer(folder, version=9, storage_plugin=plugin) as writer:
        known = {}
        for m in messages():
            if m.topic not in known:
                known[m.topic] = writer.add_connection(
                    m.topic, m.message_type, typestore=typestore()
                )
            writer.write(known[m.topic], m.log_time_ns, m.data)
    if bare:
        folder = next(file for file in folder.iterdir() if file.suffix in ('.db3', '.mcap'))
    check_content(folder)


def test_rosbag1(tmp_path):
    path = tmp_path / 'old.bag'
    store = get_typestore(Stores.ROS1_NOETIC)
    modern = typestore()
    with Rosbag1Writer(path) as writer:
        known = {}
        for m in messages():
            if m.message_type == BLOCK:
                continue
            if m.topic not in known:
                known[m.topic] = writer.add_connection(m.topic, m.message_type, typestore=store)
            message = modern.deserialize_cdr(m.data, m.message_type)
            old = store.types['std_msgs/msg/Header'](
                seq=7, stamp=message.header.stamp, frame_id=message.header.frame_id
            )
            fields = {
                name: getattr(message, name)
                for name in message.__dataclass_fields__
                if name not in ('header', '__msgtype__')
            }
            again = store.types[m.message_type](header=old, **fields)
            raw = bytes(store.serialize_ros1(again, m.message_type))
            writer.write(known[m.topic], m.log_time_ns, raw)
    check_content(path)


def test_truncated_mcap_is_read_as_far_as_it_goes(tmp_path):
    path = tmp_path / 'long.mcap'
    sent = messages(5000)
    with RecordingWriter(path) as writer:
        for m in sent:
            writer.write(m.topic, m.message_type, m.log_time_ns, m.data)
    whole = path.read_bytes()
    for share in (0.5, 0.9, 0.999):
        cut = tmp_path / 'cut.mcap'
        cut.write_bytes(whole[: int(share * len(whole))])
        recording, imu, _, _ = gathered(cut)
        n_read = sum(len(part.stamp_ns) for part in imu)
        # At most the chunk that was cut is lost.
        assert n_read >= share * 5000 - 1000
        assert 'messages read' in recording.damage()[0]
        assert 'lost' in ' '.join(recording.damage()) or share > 0.99


@pytest.mark.parametrize('seed', range(12))
def test_flipped_bytes_cost_at_most_their_chunk_and_never_a_traceback(tmp_path, seed):
    path = tmp_path / 'long.mcap'
    with RecordingWriter(path) as writer:
        for m in messages(5000):
            writer.write(m.topic, m.message_type, m.log_time_ns, m.data)
    data = bytearray(path.read_bytes())
    rng = np.random.default_rng(seed)
    place = int(rng.integers(2000, len(data) - 2000))
    data[place] ^= 1 << int(rng.integers(8))
    path.write_bytes(data)
    try:
        recording, imu, _, _ = gathered(path)
    except RecordingError as error:
        assert '\n' not in str(error)
        return
    n_read = sum(len(part.stamp_ns) for part in imu)
    assert n_read >= 3000, f'seed {seed}, byte {place}'
    assert n_read == 5000 or recording.damage(), f'seed {seed}, byte {place}: loss not stated'


def cases(tmp_path):
    good = np.zeros((100, 2))
    files = {}

    def save(name, data):
        path = tmp_path / name
        path.write_bytes(data)
        return path

    np.save(tmp_path / 'good.npy', good)
    raw = (tmp_path / 'good.npy').read_bytes()
    files['missing'] = tmp_path / 'none.mcap'
    files['empty'] = save('empty.mcap', b'')
    files['empty csv'] = save('empty.csv', b'')
    files['not mcap'] = save('x.mcap', b'hello world' * 20)
    files['not a bag'] = save('x.bag', b'hello world' * 20)
    files['not a database'] = save('x.db3', b'hello world' * 20)
    files['unknown suffix'] = save('x.dat', b'1 2 3')
    files['truncated npy'] = save('cut.npy', raw[:-100])
    files['no rate'] = tmp_path / 'good.npy'
    np.save(tmp_path / 'objects.npy', np.array([{}, []], dtype=object), allow_pickle=True)
    files['pickled'] = tmp_path / 'objects.npy'
    files['short row'] = save('short.csv', b'a,b\n1,2\n3\n')
    files['word'] = save('word.csv', b'a,b\n1,2\n3,four\n')
    files['empty folder'] = tmp_path / 'folder'
    files['empty folder'].mkdir()
    header = b"\x93NUMPY\x01\x00v\x00{'descr': '<f8', 'fortran_order': False, 'shape': (10**12,"
    files['huge npy'] = save('huge.npy', (header + b' 10**6), }').ljust(127) + b'\n')
    return files


CASES = (
    'missing',
    'empty',
    'empty csv',
    'not mcap',
    'not a bag',
    'not a database',
    'unknown suffix',
    'truncated npy',
    'pickled',
    'no rate',
    'short row',
    'word',
    'empty folder',
    'huge npy',
)


@pytest.mark.parametrize('case', CASES)
def test_bad_files_give_one_line_that_names_the_file(tmp_path, case):
    path = cases(tmp_path)[case]
    options = (
        {}
        if case in ('no rate',) or path.suffix not in ('.npy', '.csv')
        else {'sample_rate_hz': 100.0}
    )
    with pytest.raises(RecordingError) as caught:
        list(open_recording(path, **options).measurements())
    line = str(caught.value)
    assert path.name in line
    assert '\n' not in line


def test_unknown_topic_and_wrong_type_list_what_there_is(mcap, tmp_path):
    with pytest.raises(RecordingError, match='/imu/elbow'):
        open_recording(mcap, topics=['/nothing'])
    path = tmp_path / 'text.mcap'
    with RecordingWriter(path) as writer:
        writer.write('/chatter', 'std_msgs/msg/String', 1, b'\x00\x01\x00\x00\x01\x00\x00\x00\x00')
    with pytest.raises(RecordingError, match='no usable topic'):
        open_recording(path)


def test_a_topic_whose_stamps_were_never_set_is_not_used(tmp_path):
    path, sent = tmp_path / 'unset.mcap', imu_samples()
    never_set = replace(sent, stamp_ns=np.zeros_like(sent.stamp_ns))
    with RecordingWriter(path) as writer:
        for message in encode(never_set, '/imu/elbow'):
            writer.write(message.topic, message.message_type, START, message.data)
    (topic,) = open_recording(path).info().topics
    assert not topic.usable and 'all stamps are 0 s: set header.stamp' in topic.reason
    with pytest.raises(IdentificationError, match=r'all stamps are 0 s: set header\.stamp'):
        identify_recording(open_recording(path), IdentificationSettings())


def test_a_block_with_another_definition_is_refused(tmp_path):
    path = tmp_path / 'other.mcap'
    text = definition(BLOCK).replace('float64 sample_rate_hz', 'float32 sample_rate_hz')
    with RecordingWriter(path) as writer:
        writer.add_topic('/acceleration_block', BLOCK, text)
        writer.write('/acceleration_block', BLOCK, 1, encode(blocks()[0], 'x')[0].data)
        writer.write('/imu/elbow', IMU, 2, encode(imu_samples(1), 'x')[0].data)
    with pytest.raises(RecordingError, match='sample_rate_hz'):
        open_recording(path, topics=['/acceleration_block'])
    assert [topic.usable for topic in open_recording(path).info().topics] == [False, True]


@pytest.mark.parametrize('unit, factor', [('m/s^2', 1.0), ('g', 9.80665), ('mg', 9.80665e-3)])
def test_sidecar_names_rate_unit_and_channels(tmp_path, unit, factor):
    data = np.random.default_rng(SEED).normal(size=(1000, 2))
    path = tmp_path / 'x.npy'
    np.save(path, data)
    sidecar = Path(f'{path}.yaml')
    sidecar.write_text(f'sample_rate_hz: 250.0\nunit: {unit}\nchannels: [left, right]\n')
    _, _, found, _ = gathered(path)
    assert found[0].channel_names == ('left', 'right')
    assert found[0].sample_rate_hz == 250.0
    joined = np.concatenate([block.acceleration for block in found])
    assert np.allclose(joined, factor * data, rtol=1e-12)
    sidecar.write_text('sample_rate_hz: 250.0\nunits: g\n')
    with pytest.raises(RecordingError, match='units'):
        open_recording(path)


def test_csv_with_and_without_header_and_time(tmp_path):
    data = np.random.default_rng(SEED).normal(size=(200, 3))
    time_s = np.arange(200) * 0.01 + 0.5
    plain, timed = tmp_path / 'plain.csv', tmp_path / 'timed.csv'
    np.savetxt(plain, data, delimiter=',')
    np.savetxt(
        timed, np.column_stack([time_s, data]), delimiter=';', header='Time (s);X;Y;Z', comments=''
    )
    _, _, found, _ = gathered(plain, sample_rate_hz=100.0)
    assert np.allclose(np.concatenate([b.acceleration for b in found]), data)
    _, samples, _, _ = gathered(timed)
    assert samples[0].channel_names == ('X', 'Y', 'Z')
    assert int(samples[0].stamp_ns[0]) == 500_000_000
    path = to_mcap(open_recording(timed), tmp_path / 'timed.mcap')
    _, again, _, _ = gathered(path)
    assert np.allclose(np.concatenate([part.acceleration for part in again]), data)
    assert again[0].angular_velocity is None


def test_disk_full_keeps_what_was_written(tmp_path):
    resource = pytest.importorskip('resource')
    import signal

    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    path = tmp_path / 'full.mcap'
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    writer = RecordingWriter(path)
    written = 0
    resource.setrlimit(resource.RLIMIT_FSIZE, (1_000_000, before[1]))
    try:
        with pytest.raises(RecordingError, match='kept'):
            for m in messages(20000):
                writer.write(m.topic, m.message_type, m.log_time_ns, m.data)
                written += 1
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert list(tmp_path.iterdir()) == [path]
    with AnyReader([path]) as reader:
        n_read = sum(1 for _ in reader.messages())
    assert 0 < n_read <= written
    # One chunk of 256 kB at most is lost.
    assert n_read > written - 1000
    with pytest.raises(RecordingError, match='stopped'):
        writer.write('/imu/elbow', IMU, 1, b'')


def test_half_a_recording_replaces_no_whole_one(tmp_path):
    resource = pytest.importorskip('resource')
    import signal

    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    path = tmp_path / 'full.mcap'
    with RecordingWriter(path) as first:
        for m in messages(100):
            first.write(m.topic, m.message_type, m.log_time_ns, m.data)
    whole = path.read_bytes()
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    writer = RecordingWriter(path)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1_000_000, before[1]))
    try:
        with pytest.raises(RecordingError, match=r'kept in full\.unfinished\.mcap'):
            for m in messages(20000):
                writer.write(m.topic, m.message_type, m.log_time_ns, m.data)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert path.read_bytes() == whole
    with AnyReader([tmp_path / 'full.unfinished.mcap']) as reader:
        assert sum(1 for _ in reader.messages()) > 1000


def test_a_recording_that_cannot_begin_leaves_nothing(tmp_path):
    resource = pytest.importorskip('resource')
    import signal

    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))
    try:
        with pytest.raises(RecordingError, match='cannot be written'):
            RecordingWriter(tmp_path / 'x.mcap', attached={'robot.urdf': bytes(5000)})
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_in_the_place_of_a_recording_is_told_before_anything_is_recorded(tmp_path):
    path = tmp_path / 'x.mcap'
    path.mkdir()
    with pytest.raises(RecordingError, match='folder'):
        RecordingWriter(path)
    path.rmdir()
    writer = RecordingWriter(path)
    writer.write('/imu/elbow', IMU, 1, messages(1)[0].data)
    path.mkdir()
    with pytest.raises(RecordingError, match=r'kept in x\.unfinished\.mcap'):
        writer.close()
    assert (tmp_path / 'x.unfinished.mcap').stat().st_size > 100


def test_a_failure_while_writing_leaves_nothing(tmp_path):
    with pytest.raises(ValueError), RecordingWriter(tmp_path / 'x.mcap') as writer:
        writer.add_topic('/imu/elbow', IMU)
        raise ValueError
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize('message_type', [IMU, ACCEL, JOINT_STATE, BLOCK])
@pytest.mark.parametrize('seed', range(20))
def test_random_bytes_are_refused_or_decoded_never_more(message_type, seed):
    rng = np.random.default_rng(seed)
    source = {m.message_type: m.data for m in messages(2)}
    good = bytearray(source.get(message_type, source[IMU]))
    for _ in range(30):
        raw = bytearray(good)
        for place in rng.integers(0, len(raw), 6):
            raw[place] = int(rng.integers(256))
        cut = bytes(raw[: int(rng.integers(0, len(raw) + 1))])
        for data in (bytes(raw), cut):
            batch = decode([data], message_type, '/t')
            assert len(batch.measurements) + len(batch.refused) == 1, f'seed {seed}'
            assert all(isinstance(error, MessageError) for error in batch.refused)
