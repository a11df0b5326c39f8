"""The packet log: complete, within its room, readable whatever the disk does."""

import errno
from pathlib import Path

from mcap.reader import make_reader
import pytest

from modal_recordings.containers import writer
from robot_bridge.egm.egm_link import Packet
from robot_bridge.recording.packet_log import N_FILES, PacketLog

PACKET = bytes(range(200))


def messages(path):
    with path.open('rb') as file:
        return [
            (channel.topic, record.data)
            for _, channel, record in make_reader(file).iter_messages(log_time_order=False)
        ]


def fill(log, first, n):
    """Add n packets, never faster than they are written."""
    for index in range(first, first + n):
        log.add(Packet(False, index, index.to_bytes(4, 'big') + PACKET, 'accept'))
        while log.n_written + log.n_lost < index - 1000:
            pass
    return first + n


def numbers(folder):
    """Return the numbers of the packets of all files, in order."""
    found = [
        int.from_bytes(data[:4], 'big')
        for path in folder.glob('*.mcap')
        for topic, data in messages(path)
        if topic == 'egm/robot'
    ]
    return sorted(found)


def test_every_packet_and_every_state_is_there(tmp_path):
    log = PacketLog(tmp_path / 'egm.mcap')
    log.add_event(5, 'ABORTED: motors are off')
    log.add(Packet(True, 6, b'reply', 'accept'))
    log.add(Packet(False, 7, b'old', 'out_of_order'))
    fill(log, 0, 100)
    log.close()
    assert numbers(tmp_path) == list(range(100))
    found = dict(messages(tmp_path / 'egm.mcap'))
    assert found['egm/sensor'] == b'reply'
    assert found['egm/robot/out_of_order'] == b'old'
    assert b'ABORTED: motors are off' in found['robot_bridge/events']
    assert log.n_lost == 0


def test_the_log_turns_over_and_stays_within_its_room(tmp_path):
    room = 4_000_000
    log = PacketLog(tmp_path / 'egm.mcap', room)
    total = fill(log, 0, 40_000)
    log.close()
    files = list(tmp_path.iterdir())
    assert len(files) == N_FILES
    assert sum(path.stat().st_size for path in files) < 1.2 * room
    kept = numbers(tmp_path)
    # The newest are there without a gap, at least three quarters of the room of them.
    assert kept == list(range(total - len(kept), total))
    assert len(kept) * len(PACKET) > room / 2
    assert log.n_files_deleted > 0 and log.n_lost == 0


def test_every_file_of_the_log_carries_its_robot(tmp_path):
    """Also the later ones, and their room counts."""
    robot = {'robot.urdf': bytes(100_000)}
    log = PacketLog(tmp_path / 'egm.mcap', 2_000_000, robot)
    fill(log, 0, 8_000)
    log.close()
    files = list(tmp_path.iterdir())
    assert len(files) > 1
    for path in files:
        with path.open('rb') as file:
            carried = {each.name: each.data for each in make_reader(file).iter_attachments()}
        assert carried['robot.urdf'] == robot['robot.urdf']
        assert b'autonomous_modal_analysis' in carried['software.txt']
    assert sum(path.stat().st_size for path in files) < 1.2 * 2_000_000


@pytest.fixture
def full_disk(monkeypatch):
    """Return a disk with room for a number of bytes in a folder; writes beyond it fail."""

    class Disk:
        def __init__(self):
            self.folder, self.room = None, 0

        def write(self, file, data):
            used = sum(path.stat().st_size for path in Path(self.folder).iterdir())
            if self.folder and used + len(data) > self.room:
                raise OSError(errno.ENOSPC, 'No space left on device')
            return file.write(data)

    disk = Disk()

    class Stream(writer.WholeWrites):
        def write(self, data):
            disk.write(self._file, data)
            self.position += len(data)
            return len(data)

    monkeypatch.setattr(writer, 'WholeWrites', Stream)
    return disk


def test_on_a_full_disk_the_oldest_file_gives_way(tmp_path, full_disk):
    full_disk.folder, full_disk.room = tmp_path, 2_000_000
    log = PacketLog(tmp_path / 'egm.mcap', 4_000_000)  # more than the disk has
    total = fill(log, 0, 30_000)
    log.close()
    assert log.failure == ''
    assert log.n_files_deleted > 0
    kept = numbers(tmp_path)
    assert kept[-1] == total - 1
    assert sum(path.stat().st_size for path in tmp_path.iterdir()) <= full_disk.room


def test_a_full_disk_without_an_older_file_ends_the_log_readable(tmp_path, full_disk):
    full_disk.folder, full_disk.room = tmp_path, 700_000
    log = PacketLog(tmp_path / 'egm.mcap', 400_000_000)
    fill(log, 0, 10_000)
    log.close()
    assert 'No space left' in log.failure
    assert log.n_lost > 0
    kept = numbers(tmp_path)
    assert kept == list(range(len(kept))) and len(kept) > 500
