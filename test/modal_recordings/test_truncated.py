"""A recording cut anywhere is read up to the cut, and one line says what that cost."""

import re
import struct

from mcap.writer import CompressionType, Writer
import numpy as np
import pytest
from rosbags.rosbag1 import Writer as Rosbag1Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Rosbag2Writer
from rosbags.typesys import get_typestore, Stores

from modal_core.errors import RecordingError
from modal_core.measurements import StampedSamples
from modal_recordings import open_recording, RecordingWriter
from modal_recordings.containers import McapFile
from modal_recordings.messages import definition, encode, IMU, typestore

SEED = 5
STEP_NS = 10_000_000
N_MESSAGES = 9000
RECORD = struct.Struct('<BQ')
LOSS = re.compile(
    r'file ends at byte (\d+) inside a chunk, about (\S+) s / (\d+) messages of it lo'
)


def messages(n=N_MESSAGES):
    rng = np.random.default_rng(SEED)
    stamps = np.arange(1, n + 1, dtype=np.int64) * STEP_NS
    return encode(StampedSamples('/imu', 'tool0', stamps, rng.normal(size=(n, 3))), '/imu')


def by_recording_writer(path, compression='none'):
    with RecordingWriter(path, compression) as writer:
        for m in messages():
            writer.write(m.topic, m.message_type, m.log_time_ns, m.data)


def by_rosbags(path):
    folder = path.with_suffix('')
    with Rosbag2Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connection = writer.add_connection('/imu', IMU, typestore=typestore())
        for m in messages():
            writer.write(connection, m.log_time_ns, m.data)
    next(folder.glob('*.mcap')).rename(path)


def by_mcap(path, compression):
    with path.open('wb') as file:
        writer = Writer(file, compression=compression, chunk_size=1 << 20)
        writer.start(profile='ros2')
        schema = writer.register_schema(IMU, 'ros2msg', definition(IMU).encode())
        channel = writer.register_channel('/imu', 'cdr', schema)
        for m in messages():
            writer.add_message(channel, m.log_time_ns, m.data, m.log_time_ns)
        writer.finish()


WRITERS = {
    'recording writer': by_recording_writer,
    'recording writer, zstd': lambda path: by_recording_writer(path, 'zstd'),
    'rosbags': by_rosbags,
    'mcap, lz4': lambda path: by_mcap(path, CompressionType.LZ4),
    'mcap, zstd': lambda path: by_mcap(path, CompressionType.ZSTD),
}


def records(data):
    """Return (opcode, start, stop) of every top record of a sound file."""
    position, found = 8, []
    while position < len(data) - 8:
        opcode, length = RECORD.unpack_from(data, position)
        found.append((opcode, position, position + RECORD.size + length))
        position = found[-1][2]
    return found


def read(path):
    """Return what the file gives and says, checked to be the first messages sent, unchanged."""
    file = McapFile(path)
    got = list(file.messages())
    sent = messages()[: len(got)]
    assert [m.log_time_ns for m in got] == [m.log_time_ns for m in sent]
    assert [bytes(m.data) for m in got] == [bytes(m.data) for m in sent]
    return len(got), file.damage()


@pytest.mark.parametrize('share', [0.3, 0.55, 0.7])
@pytest.mark.parametrize('kind', WRITERS)
def test_the_part_of_a_chunk_before_the_cut_is_read(tmp_path, kind, share):
    path = tmp_path / 'a.mcap'
    WRITERS[kind](path)
    data = path.read_bytes()
    chunks = [record for record in records(data) if record[0] == 6]
    inside = chunks[int(share * len(chunks))]
    cut = inside[1] + int(share * (inside[2] - inside[1]))
    before = tmp_path / 'before.mcap'
    before.write_bytes(data[: inside[1]])
    n_before, _ = read(before)
    path.write_bytes(data[:cut])
    n_read, damage = read(path)
    assert len(damage) == 1, damage
    byte, lost_s, n_lost = LOSS.search(damage[0]).groups()
    assert int(byte) == cut
    assert damage[0].endswith(f'{n_read} messages read')
    after = tmp_path / 'after.mcap'
    after.write_bytes(data[: inside[2]])
    n_after, _ = read(after)
    # What the statement estimates is known here: the whole chunk holds these messages.
    assert int(n_lost) == pytest.approx(n_after - n_read, rel=0.05, abs=5)
    assert float(lost_s) == pytest.approx((n_after - n_read) * STEP_NS / 1e9, rel=0.01)
    share_of_chunk = (cut - inside[1]) / (inside[2] - inside[1])
    if kind in ('rosbags', 'recording writer'):
        expected = n_before + share_of_chunk * (n_after - n_before)
        assert n_read == pytest.approx(expected, abs=15)
    elif kind == 'mcap, lz4':
        # Blocks of 64 kB come out whole.
        assert n_read >= n_before + share_of_chunk * (n_after - n_before) - 500
    else:
        assert n_read >= n_before


@pytest.mark.parametrize('kind', ['recording writer', 'rosbags'])
def test_a_cut_beside_a_record_boundary_costs_nothing_before_it(tmp_path, kind):
    path, cut_path = tmp_path / 'a.mcap', tmp_path / 'cut.mcap'
    WRITERS[kind](path)
    data = path.read_bytes()
    found = records(data)
    ends = [stop for opcode, _, stop in found if opcode in (6, 15)]
    ends += [stop for _, _, stop in found[-4:]]
    n_least = 0
    for end in ends:
        for cut in (end - 1, end, end + 1):
            cut_path.write_bytes(data[:cut])
            n_read, damage = read(cut_path)
            assert len(damage) <= 1, (cut, damage)
            # One byte of a chunk costs its last message alone, and later cuts no less.
            assert n_read >= n_least, cut
            n_least = n_read
            assert damage or n_read == N_MESSAGES
            if cut < end and damage and 'inside a chunk' in damage[0]:
                assert ' / 1 messages' in damage[0] or ' / 0 messages' in damage[0], damage
    assert n_least == N_MESSAGES


def test_a_cut_at_every_kind_of_byte_of_a_chunk_head_is_one_line(tmp_path):
    path, cut_path = tmp_path / 'a.mcap', tmp_path / 'cut.mcap'
    by_recording_writer(path)
    data = path.read_bytes()
    start = [start for opcode, start, _ in records(data) if opcode == 6][2]
    counts = set()
    for cut in range(start, start + 60):
        cut_path.write_bytes(data[:cut])
        n_read, damage = read(cut_path)
        assert len(damage) == 1, (cut, damage)
        assert f'file ends at byte {cut}' in damage[0]
        counts.add(n_read)
    assert len(counts) == 1
    assert counts.pop() > 0


def test_a_cut_before_any_message_claims_no_number(tmp_path):
    path = tmp_path / 'a.mcap'
    by_rosbags(path)
    data = path.read_bytes()
    start = next(start for opcode, start, _ in records(data) if opcode == 6)
    path.write_bytes(data[: start + 80])
    n_read, damage = read(path)
    assert n_read == 0
    assert len(damage) == 1
    assert 'an unknown number of messages of it lost' in damage[0]


def test_truncated_npy_states_rows(tmp_path):
    path = tmp_path / 'x.npy'
    np.save(path, np.zeros((1000, 3)))
    path.write_bytes(path.read_bytes()[: 128 + 24 * 600 + 7])
    with pytest.raises(RecordingError, match='found 600 whole rows, expected 1000 rows'):
        open_recording(path, sample_rate_hz=100.0)
    np.save(path, np.asfortranarray(np.zeros((1000, 3))))
    path.write_bytes(path.read_bytes()[:5000])
    with pytest.raises(RecordingError, match='found 4872 bytes, expected 24000 bytes'):
        open_recording(path, sample_rate_hz=100.0)


@pytest.mark.parametrize('suffix', ['.npy', '.bag', '.db3', '.csv'])
def test_garbage_states_found_and_expected_in_own_words(tmp_path, suffix):
    path = tmp_path / f'x{suffix}'
    path.write_bytes(np.random.default_rng(SEED).bytes(5000))
    options = {'sample_rate_hz': 100.0} if suffix in ('.npy', '.csv') else {}
    with pytest.raises(RecordingError) as caught:
        open_recording(path, **options)
    line = str(caught.value)
    assert 'found' in line and 'expected' in line and '\n' not in line
    for leaked in ('pickle', 'mmap', 'codec', 'utf-8', "('"):
        assert leaked not in line, line


def test_truncated_rosbag1_and_database_state_bytes(tmp_path):
    old, store = tmp_path / 'old.bag', get_typestore(Stores.ROS1_NOETIC)
    with Rosbag1Writer(old) as writer:
        connection = writer.add_connection('/a', 'std_msgs/msg/String', typestore=store)
        for stamp in range(1000):
            writer.write(connection, stamp, b'\x04\x00\x00\x00abcd')
    folder = tmp_path / 'new'
    with Rosbag2Writer(folder, version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        connection = writer.add_connection('/imu', IMU, typestore=typestore())
        for m in messages(1000):
            writer.write(connection, m.log_time_ns, m.data)
    for path in (old, next(folder.glob('*.db3'))):
        data = path.read_bytes()
        path.write_bytes(data[: int(0.7 * len(data))])
        with pytest.raises(RecordingError) as caught:
            open_recording(path)
        line = str(caught.value)
        assert 'truncated' in line and f'found {int(0.7 * len(data))} bytes' in line, line
        assert re.search(r'expected (more than )?\d+ bytes', line), line
        assert 'Header could not' not in line and 'malformed' not in line
