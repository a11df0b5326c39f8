"""Files inside recordings: they come back as they were put in, and harm nobody."""

import struct
import zlib

from mcap.reader import make_reader
import numpy as np
import pytest

from modal_core.channel import Sensor, SensorLayout
from modal_core.errors import LayoutError, RecordingError, SettingsError
from modal_core.files.version import software
from modal_recordings import open_recording, RecordingWriter, to_mcap
from modal_recordings.containers import McapFile
from modal_recordings.messages import (
    attached_layout,
    attached_software,
    Attachment,
    LARGEST_BYTES,
    save_attachments,
)

pytest.importorskip('pinocchio')
from structural_model import load_layout, load_robot
from structural_model.robot_files import robot_of_files
from structural_model.robot_writer import layout_text, model_mapping, robot_content

ROBOT = 'irb6660_205_190'
LAYOUT = SensorLayout((Sensor('tip', 'link_6', (0.0, 0.1, 0.2), unit='g', delay_s=0.01),))
FILES = {'robot.urdf': b'<robot/>', 'sensors.yaml': layout_text(LAYOUT).encode(), 'a.bin': b'\0\1'}


def written(path, files=FILES, n_messages=3, close=True):
    writer = RecordingWriter(path, attached=files)
    for number in range(n_messages):
        writer.write('/text', 'std_msgs/msg/String', number, b'\0\1\0\0\1\0\0\0\0')
    if close:
        return writer.close()
    writer.flush()
    return writer.temporary


def read(path):
    return open_recording(path, to_look=True).attachments()


def test_what_is_attached_comes_back(tmp_path):
    found = read(written(tmp_path / 'a.mcap'))
    assert {each.name: each.data for each in found if each.name in FILES} == FILES
    assert [each.problem for each in found] == [''] * 4
    assert found[0].media_type == 'application/xml'
    assert attached_software(found) == software()
    assert attached_layout(found, 'here').sensors == LAYOUT.sensors


def test_other_readers_find_them_too(tmp_path):
    with written(tmp_path / 'a.mcap').open('rb') as file:
        found = {each.name: each.data for each in make_reader(file).iter_attachments()}
    assert FILES.items() <= found.items()


def test_a_recording_that_was_never_finished_has_them(tmp_path):
    path = written(tmp_path / 'a.mcap', close=False)
    assert 'unfinished' in path.name
    assert {each.name: each.data for each in read(path)}.items() >= FILES.items()


def test_the_same_messages_make_the_same_file(tmp_path):
    one, other = (written(tmp_path / name).read_bytes() for name in ('a.mcap', 'b.mcap'))
    assert one == other


def test_converting_keeps_them(tmp_path):
    kept = to_mcap(open_recording(written(tmp_path / 'a.mcap'), to_look=True), tmp_path / 'b.mcap')
    found = McapFile(kept).attachments()
    assert {each.name: each.data for each in found}.items() >= FILES.items()
    np.save(tmp_path / 'c.npy', np.random.default_rng(1).normal(size=(500, 2)))
    array = open_recording(tmp_path / 'c.npy', sample_rate_hz=100.0, unit='g')
    assert array.attachments() == ()
    assert [each.name for each in read(to_mcap(array, tmp_path / 'c.mcap'))] == ['software.txt']


def test_a_folder_of_files_has_those_of_its_first(tmp_path):
    for name in ('bag_0.mcap', 'bag_1.mcap'):
        written(tmp_path / 'bag' / name)
    assert len(read(tmp_path / 'bag')) == 4


def test_a_robot_goes_through_a_recording(tmp_path):
    model, layout = load_robot(ROBOT), load_layout(ROBOT)
    found = {
        each.name: each.data
        for each in read(written(tmp_path / 'a.mcap', robot_content(model, layout)))
    }
    back = robot_of_files(found['robot.urdf'], found['model.yaml'].decode(), 'here')
    assert model_mapping(back) == model_mapping(model)
    assert back.robot.text == model.robot.text
    q = model.pose('P1')
    np.testing.assert_array_equal(
        back.modes(q, layout.channels).frequency_hz, model.modes(q, layout.channels).frequency_hz
    )


def test_one_that_is_changed_is_named_and_not_read(tmp_path):
    path = written(tmp_path / 'a.mcap')
    path.write_bytes(path.read_bytes().replace(b'<robot/>', b'<ribot/>'))
    first, *others = read(path)
    assert (first.name, first.data, first.problem) == ('robot.urdf', b'', 'with a wrong checksum')
    assert all(each.data for each in others)
    with pytest.raises(RecordingError, match='wrong checksum'):
        save_attachments((first, *others), tmp_path / 'out', path)
    assert not (tmp_path / 'out').exists()


def test_one_that_is_too_large_is_named_and_not_read(tmp_path):
    found = read(written(tmp_path / 'a.mcap', {'a.bin': bytes(LARGEST_BYTES + 1), 'b': b'1'}))
    assert (found[0].n_bytes, found[0].data) == (LARGEST_BYTES + 1, b'')
    assert found[0].problem == 'too large' and found[1].data == b'1'


def test_many_are_too_much(tmp_path):
    many = {f'{number}.bin': bytes(LARGEST_BYTES) for number in range(6)}
    found = read(written(tmp_path / 'a.mcap', many))
    assert sum(len(each.data) for each in found) <= 20_000_000
    assert [each.problem for each in found[:6]] == [''] * 4 + ['too large'] * 2
    short = {f'{number}.txt': b'1' for number in range(300)}
    assert len(read(written(tmp_path / 'b.mcap', short))) == 100


@pytest.mark.parametrize('seed', range(5))
def test_bytes_that_are_changed_anywhere_end_in_no_traceback(tmp_path, seed):
    """Attachments, their index and lengths, with 1 to 30 bytes changed at random."""
    print('seed', seed)
    rng = np.random.default_rng(seed)
    path = written(tmp_path / 'a.mcap')
    good = path.read_bytes()
    for _ in range(60):
        data = bytearray(good)
        for at in rng.integers(8, len(good), rng.integers(1, 30)):
            data[at] = rng.choice([0, 255, rng.integers(256)])
        path.write_bytes(bytes(data))
        try:
            found = read(path)
        except RecordingError:
            continue
        names = {each.name: each.data for each in found if not each.problem}
        assert len(found) <= 100
        assert all(len(each.data) <= len(good) for each in found)
        for name in names.keys() & FILES.keys():
            assert names[name] == FILES[name]


def test_an_index_that_points_anywhere_is_no_way_out(tmp_path):
    path = written(tmp_path / 'a.mcap')
    data = bytearray(path.read_bytes())
    at = data.rfind(b'robot.urdf') - 4 - 8 - 16 - 8 - 8
    assert data[at - 9] == 10
    for where in (0, 2**64 - 1, 2**63, len(data), len(data) - 3):
        data[at : at + 8] = struct.pack('<Q', where)
        path.write_bytes(bytes(data))
        assert read(path)[0].problem == f'damaged at byte {where}'


@pytest.mark.parametrize('name', ['../out.txt', '/tmp/out.txt', '.bashrc', 'a/b', '', 'a\nb'])
def test_a_name_that_is_a_path_is_not_written(tmp_path, name):
    found = read(written(tmp_path / 'a.mcap', {name: b'1'}))
    with pytest.raises(RecordingError, match='plain file name'):
        save_attachments(found, tmp_path / 'out', 'a.mcap')
    assert not (tmp_path / 'out').exists()


def test_nothing_is_replaced(tmp_path):
    found = read(written(tmp_path / 'a.mcap'))
    assert len(save_attachments(found, tmp_path / 'out', 'a.mcap')) == 4
    assert (tmp_path / 'out' / 'robot.urdf').read_bytes() == FILES['robot.urdf']
    (tmp_path / 'out' / 'a.bin').unlink()
    with pytest.raises(RecordingError, match='is there already'):
        save_attachments(found, tmp_path / 'out', 'a.mcap')
    assert not (tmp_path / 'out' / 'a.bin').exists()


def test_a_layout_that_is_none_is_told():
    def of(data):
        return attached_layout((Attachment('sensors.yaml', '', len(data), data),), 'a.mcap')

    assert attached_layout((), 'a.mcap') is None
    with pytest.raises(LayoutError, match=r'a\.mcap: sensors\.yaml: no sensors'):
        of(b'x: 1')
    with pytest.raises(SettingsError, match=r'a\.mcap: sensors\.yaml: not UTF-8'):
        of(b'\xff\xfe')


def test_a_writer_that_makes_no_checksum_is_read(tmp_path):
    path = written(tmp_path / 'a.mcap')
    data = bytearray(path.read_bytes())
    at = data.find(b'<robot/>') + 8
    start = data.find(b'robot.urdf') - 4 - 16
    assert struct.unpack_from('<I', data, at)[0] == zlib.crc32(data[start:at])
    data[at : at + 4] = bytes(4)
    path.write_bytes(bytes(data))
    assert read(path)[0].data == b'<robot/>'
