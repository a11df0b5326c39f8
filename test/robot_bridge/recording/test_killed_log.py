"""A bridge or recorder that is killed leaves a record that ends where it was killed."""

import os
from pathlib import Path
import signal
import subprocess
import sys
import time

import pytest

from modal_recordings import open_recording, RecordingWriter
from robot_bridge.egm.egm_link import Packet
from robot_bridge.recording.packet_log import PacketLog
from test.support.domains import ros_domain

AMA = Path(sys.executable).with_name('ama')
MOST_LOST_S = 0.2
LOGGING = """
import sys, time
from pathlib import Path
from robot_bridge.egm.egm_link import Packet
from robot_bridge.recording.packet_log import PacketLog

log = PacketLog(Path(sys.argv[1]))
log.add_event(time.time_ns(), 'RUNNING: started by the operator')
while not log.n_written:  # the definitions of messages are read once
    time.sleep(0.01)
for number in range(100_000):
    now_ns = time.time_ns()
    log.add(Packet(number % 2 == 1, now_ns, bytes(150), 'accept'))
    print(now_ns, flush=True)
    if number == 200:
        log.add_event(now_ns, 'ABORTED: axis 3 does not follow')
    time.sleep(0.002)
"""


def last_ns(path):
    """Return the time of the last message that can be read."""
    recording = open_recording(path, to_look=True)
    return max(message.log_time_ns for message in recording.file.messages())


@pytest.mark.parametrize('when_s', [0.9, 1.33])
@pytest.mark.slow
def test_a_killed_bridge_leaves_its_record_to_the_end(tmp_path, when_s):
    path = tmp_path / 'egm.mcap'
    process = subprocess.Popen(
        [sys.executable, '-c', LOGGING, str(path)], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout.readline()
    time.sleep(when_s)
    process.send_signal(signal.SIGKILL)
    said, _ = process.communicate()
    (left,) = tmp_path.iterdir()
    assert left.name == 'egm.unfinished.mcap'
    assert (int(said.split()[-1]) - last_ns(left)) * 1e-9 < MOST_LOST_S
    info = subprocess.run(
        [str(AMA), 'info', str(left)], capture_output=True, text=True, check=False
    )
    assert info.returncode == 0, info.stderr
    assert 'egm/robot' in info.stdout
    assert 'RUNNING: started by the operator' in info.stdout
    if when_s > 1.0:
        assert 'ABORTED: axis 3 does not follow' in info.stdout


def test_a_state_is_on_the_disk_when_it_is_told(tmp_path):
    log = PacketLog(tmp_path / 'egm.mcap')
    log.add(Packet(False, 5, b'last', 'accept'))
    log.add_event(6, 'ABORTED: second_sender')
    deadline = time.monotonic() + 5.0
    while b'second_sender' not in (tmp_path / 'egm.unfinished.mcap').read_bytes():
        assert time.monotonic() < deadline
        time.sleep(0.005)
    assert last_ns(tmp_path / 'egm.unfinished.mcap') == 6
    log.close()


def test_the_next_log_does_not_touch_what_an_accident_left(tmp_path):
    path = tmp_path / 'egm.mcap'
    left = tmp_path / 'egm.unfinished.mcap'
    child = 'import os, sys; from robot_bridge.recording.packet_log import PacketLog; '
    child += 'from pathlib import Path; PacketLog(Path(sys.argv[1])); os._exit(9)'
    subprocess.run([sys.executable, '-c', child, str(path)], check=False)
    before = left.read_bytes()
    for _ in range(2):
        log = PacketLog(path)
        log.add_event(6, 'IDLE')
        log.close()
    assert left.read_bytes() == before
    assert sorted(item.name for item in tmp_path.iterdir()) == [path.name, left.name]


def test_what_was_flushed_is_read_from_a_file_that_was_never_finished(tmp_path):
    child = os.fork()
    if child == 0:
        writer = RecordingWriter(tmp_path / 'a.mcap', 'zstd')
        for index in range(50):
            writer.write('/chatter', 'std_msgs/msg/String', index, bytes(12))
        writer.flush()
        writer.write('/chatter', 'std_msgs/msg/String', 99, bytes(12))
        os.kill(os.getpid(), signal.SIGKILL)
    os.waitpid(child, 0)
    assert last_ns(tmp_path / 'a.unfinished.mcap') == 49


@pytest.mark.node
def test_a_killed_recorder_leaves_its_record_to_the_end(tmp_path):
    pytest.importorskip('rclpy')
    child = """
import os, signal, sys, threading, time
from pathlib import Path
import rclpy
from sensor_msgs.msg import JointState
from autonomous_modal_analysis.live.recorder_node import RecorderNode
from autonomous_modal_analysis.live.spinning_node import spinning

rclpy.init(domain_id=int(sys.argv[2]))
recorder = RecorderNode(Path(sys.argv[1]), {'/joint_states': JointState})
with spinning(recorder):
    publisher = recorder.create_publisher(JointState, '/joint_states', 100)
    while not publisher.get_subscription_count():
        time.sleep(0.01)
    begin = time.monotonic()
    while time.monotonic() < begin + 1.5:
        message = JointState(name=['a'], position=[1.0])
        publisher.publish(message)
        time.sleep(0.01)
    print(time.time_ns(), flush=True)
    os.kill(os.getpid(), signal.SIGKILL)
"""
    domain = ros_domain()
    run = subprocess.run(
        [sys.executable, '-c', child, str(tmp_path / 'r.mcap'), str(domain)],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert run.stdout, run.stderr
    assert (int(run.stdout) - last_ns(tmp_path / 'r.unfinished.mcap')) * 1e-9 < MOST_LOST_S
