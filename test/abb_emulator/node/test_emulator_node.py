"""The emulator as one process: modules, web services, IMUs, faults, reports."""

import select
import shutil
import socket
import threading

import numpy as np
import pytest

from modal_core.files.share import share_path
from test.support.web_client import WebClient

pytestmark = pytest.mark.node
RATE_HZ, CYCLE_US = 1024.0, 4032
IMU_PERIOD_NS = 1e9 / RATE_HZ
STREAM = """MODULE Stream
  CONST jointtarget jA:=[[3,45,-10,90,-90,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST jointtarget jB:=[[-3,45,-10,90,-90,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  VAR egmident e;
  PROC main()
    EGMGetId e;
    EGMSetupUC ROB_1,e,"default","UCdevice"\\Joint;
    EGMStreamStart e\\SampleRate:=4;
    FOR i FROM 1 TO 100000 DO
      MoveAbsJ jA\\NoEOffs,v50,fine,tool0;
      MoveAbsJ jB\\NoEOffs,v50,fine,tool0;
    ENDFOR
  ENDPROC
ENDMODULE
"""
SENSORS = """sensors:
- {name: wrist, frame_id: link_5, position_m: [0.05, 0.0, 0.12]}
- {name: spindle, frame_id: flange, position_m: [0.2, 0.0, 0.08]}
- {name: tool, frame_id: flange, position_m: [0.2, 0.0, 0.08], topic: imu/tool}
"""
SHORT = """MODULE Short
  CONST jointtarget jC:=[[1,45,-10,90,-90,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PROC main()
    MoveAbsJ jC\\NoEOffs,v50,fine,tool0;
  ENDPROC
ENDMODULE
"""


class Emulator:
    """The process, what it sends by UDP, and what it publishes."""

    def __init__(self, processes, operator, drivers, peers, folder):
        from rclpy.qos import QoSProfile, ReliabilityPolicy
        from sensor_msgs.msg import Imu

        from oma_msgs.msg import AccelerationBlock

        self.operator, self.peers = operator, peers
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(('127.0.0.1', 0))
        self.heard, self.blocks, self.imu = [], [], []
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._listen, daemon=True)
        self._thread.start()
        best = QoSProfile(depth=5000, reliability=ReliabilityPolicy.BEST_EFFORT)
        create = operator.node.create_subscription
        sure = QoSProfile(depth=5000, reliability=ReliabilityPolicy.RELIABLE)
        create(AccelerationBlock, '/acceleration_block', self.blocks.append, sure)
        create(Imu, '/imu/tool', self._keep_imu, best)
        with socket.socket() as probe:
            probe.bind(('127.0.0.1', 0))
            self.web_port = probe.getsockname()[1]
        self.folder, self.module = folder, folder / 'stream.mod'
        self.module.write_text(STREAM)
        self.process = processes(
            'abb_emulator',
            robot=str(self._robot()),
            sensor_port=self.socket.getsockname()[1],
            start_program=False,
            sample_rate_hz=RATE_HZ,
            rws__port=self.web_port,
            module=str(self.module),
            effects='[{type: payload, link: flange, mass: 20}]',
        )
        ended = self.process.process.poll
        operator.until(lambda: self.blocks or ended() is not None, 'samples')
        assert ended() is None, self.process.stop()

    def _robot(self):
        """Return a robot whose flange carries an IMU beside recorded accelerometers."""
        robot = self.folder / 'robot'
        shutil.copytree(share_path('config', 'robots', 'irb6660_205_190'), robot)
        (robot / 'sensors.yaml').write_text(SENSORS)
        return robot

    def _keep_imu(self, message):
        force, turn, stamp = message.linear_acceleration, message.angular_velocity, message.header
        self.imu.append(
            (
                stamp.stamp.sec * 10**9 + stamp.stamp.nanosec,
                *(force.x, force.y, force.z, turn.x, turn.y, turn.z),
                stamp.frame_id,
                message.orientation_covariance[0],
            )
        )

    def _listen(self):
        while not self._closing.is_set():
            if select.select([self.socket], [], [], 0.1)[0]:
                data = self.socket.recv(4096)
                self.heard.append(self.peers.EgmRobot.FromString(data))

    def some(self, n=60):
        """Return the next n messages of the controller."""
        first = len(self.heard)
        self.operator.until(lambda: len(self.heard) >= first + n, f'{n} messages')
        return self.heard[first : first + n]

    def last(self, n=60):
        """Return the numbers of the last messages that have come."""
        return np.array([message.header.seqno for message in self.heard[-n:]], int)

    def rows(self, n=64):
        """Return the last rows of the common recorder, at least n."""
        blocks = self.blocks[-(n // 64 + 1) :]
        return np.concatenate([np.array(b.acceleration).reshape(b.n_samples, -1) for b in blocks])

    def until(self, condition, what):
        """Wait until new messages and blocks make something true."""
        first = len(self.blocks), len(self.heard)
        self.operator.until(
            lambda: (
                len(self.blocks) > first[0] and len(self.heard) > first[1] + 60 and condition()
            ),
            what,
        )

    def fault(self, name, **fields):
        from oma_msgs.srv import InjectFault

        return self.operator.call(
            '/abb_emulator/inject_fault', InjectFault, fault=name,
            **{key: value if key == 'target' else float(value) for key, value in fields.items()},
        )  # fmt: skip

    def clear(self):
        assert self.fault('clear').accepted

    def ask(self, service):
        return self.operator.call(f'/abb_emulator/{service}')

    def close(self):
        self._closing.set()
        self._thread.join()
        self.socket.close()


@pytest.fixture(scope='module')
def emulator(processes, operator, drivers, peers, tmp_path_factory):
    made = Emulator(processes, operator, drivers, peers, tmp_path_factory.mktemp('emulator'))
    yield made
    made.close()


@pytest.fixture
def streaming(emulator):
    """Be in the stream of the endless module, without any fault."""
    emulator.clear()
    emulator.operator.call('/abb_emulator/motors_on')
    emulator.ask('start_program')
    emulator.some(20)
    return emulator


@pytest.mark.smoke
def test_a_module_is_started_and_streams_from_seqno_0(emulator):
    assert emulator.heard == []
    assert emulator.ask('start_program').success
    emulator.some(100)
    first = emulator.heard[:100]
    assert [m.header.seqno for m in first] == list(range(100))
    times = np.array([m.feedBack.time.sec * 10**6 + m.feedBack.time.usec for m in first])
    np.testing.assert_allclose(np.diff(times), CYCLE_US, atol=1)
    assert {m.rapidExecState.state for m in first} == {2}
    assert {m.mciState.state for m in first} == {2}
    assert not emulator.ask('start_program').success
    assert not emulator.ask('reset_program').success
    # Another module is not loaded while one runs; nor is a broken one ever.
    assert 'running' in emulator.ask('load_module').message
    assert np.ptp([m.feedBack.joints.joints[0] for m in emulator.some(400)]) > 0.1


def test_imus_send_every_sample_with_gravity_and_turn(streaming):
    emulator = streaming
    first = len(emulator.imu)
    emulator.operator.until(lambda: len(emulator.imu) > first + 1000, 'IMU messages')
    rows = emulator.imu[first : first + 1000]
    assert {row[7] for row in rows} == {'flange'}
    assert {row[8] for row in rows} == {-1.0}  # no orientation, REP 145
    stamps = np.array([row[0] for row in rows], float)
    steps = np.diff(stamps) / IMU_PERIOD_NS
    # Best effort may lose some on their way; none is moved.
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-2)
    assert steps.min() > 0.5
    values = np.array([row[1:7] for row in rows])
    assert np.linalg.norm(values[:, :3].mean(axis=0)) == pytest.approx(9.81, rel=0.05)
    # The arm turns about axis 1 and no other.
    emulator.operator.until(
        lambda: max(abs(row[4]) + abs(row[5]) + abs(row[6]) for row in emulator.imu[first:]) > 0.02
    )


def test_blocks_run_on_without_gaps(streaming):
    first = len(streaming.blocks)
    streaming.operator.until(lambda: len(streaming.blocks) >= first + 16, 'blocks')
    blocks = streaming.blocks[first:]
    names = [f'{sensor}.{axis}' for sensor in ('wrist', 'spindle') for axis in 'xyz']
    assert blocks[0].channel_names == names
    index = [block.first_index for block in blocks]
    np.testing.assert_array_equal(np.diff(index), 64)
    stamps = [block.header.stamp.sec * 10**9 + block.header.stamp.nanosec for block in blocks]
    for number, stamp in zip(index, stamps, strict=True):
        assert abs(stamp - stamps[0] - (number - index[0]) * IMU_PERIOD_NS) < 2


def test_the_link_loses_doubles_and_overtakes(streaming):
    emulator = streaming
    assert emulator.fault('drop', value=0.5, target='robot').accepted
    emulator.until(lambda: np.diff(emulator.last()).max() > 1, 'gaps')
    emulator.clear()
    emulator.until(lambda: np.all(np.diff(emulator.last()) == 1), 'no gaps')
    assert emulator.fault('duplicate', value=1.0).accepted
    emulator.until(lambda: len(set(emulator.last())) <= 31, 'pairs')
    emulator.clear()
    assert emulator.fault('reorder', value=1.0).accepted
    emulator.until(lambda: np.diff(emulator.last()).min() < 0, 'another order')
    emulator.clear()
    emulator.until(lambda: np.all(np.diff(emulator.last()) == 1), 'the right order')
    assert emulator.fault('clock_skew', value=0.008).accepted

    def cycle_us():
        times = [m.feedBack.time for m in emulator.heard[-60:]]
        return np.mean(np.diff([t.sec * 10**6 + t.usec for t in times]))

    emulator.until(lambda: cycle_us() == pytest.approx(CYCLE_US * 1.008, rel=1e-4), 'fast clock')
    emulator.clear()


def test_the_link_is_late(streaming):
    """Behind the samples of the same cell; both carry the emulated time."""
    emulator = streaming

    def behind_s():
        sampled, sent = emulator.blocks[-1].header.stamp, emulator.heard[-1].feedBack.time
        return sampled.sec - sent.sec + 1e-9 * sampled.nanosec - 1e-6 * sent.usec

    emulator.until(lambda: behind_s() < 0.3, 'messages in time')
    assert emulator.fault('delay', value=1.0, target='robot').accepted
    emulator.until(lambda: behind_s() > 0.6, 'late messages')
    emulator.clear()
    emulator.until(lambda: behind_s() < 0.3, 'messages in time')


def test_the_session_restarts_and_the_state_is_undefined(streaming):
    emulator = streaming
    first = len(emulator.heard)
    assert emulator.fault('restart_session').accepted
    emulator.operator.until(
        lambda: 0 in [m.header.seqno for m in emulator.heard[first:]], 'seqno 0'
    )
    assert emulator.fault('rapid_undefined').accepted
    emulator.operator.until(lambda: emulator.heard[-1].rapidExecState.state == 0, 'UNDEFINED')
    emulator.clear()
    emulator.operator.until(lambda: emulator.heard[-1].rapidExecState.state == 2, 'RUNNING')


def test_sensors_fail_one_by_one(streaming):
    emulator = streaming
    moving = [0, 2, 3, 4, 5]
    assert emulator.fault('sensor_dropout', target='wrist.y').accepted
    emulator.until(lambda: not emulator.rows()[:, 1].any(), 'zeros')
    assert emulator.rows()[:, moving].any(axis=0).all()
    emulator.clear()
    assert emulator.fault('sensor_nan', value=0.5, target='spindle').accepted
    emulator.until(lambda: np.all(np.isnan(emulator.rows())[:, 3:].mean(axis=0) > 0.2), 'NaN')
    assert not np.isnan(emulator.rows()[:, :3]).any()
    emulator.clear()
    emulator.until(lambda: np.isfinite(emulator.rows()).all(), 'numbers')
    assert emulator.fault('sensor_clipping', value=0.001, target='wrist.z').accepted
    # Within a block: clipping is about its median.
    emulator.until(lambda: np.ptp(emulator.rows()[-64:, 2]) < 0.0025, 'clipped')
    emulator.clear()
    assert emulator.fault('sensor_flatline', target='tool').accepted
    emulator.until(lambda: len({row[1:7] for row in emulator.imu[-100:]}) == 1, 'a flat line')
    emulator.clear()
    assert emulator.fault('block_dropout', value=0.5).accepted

    def steps():
        return np.diff([block.first_index for block in emulator.blocks[-20:]])

    emulator.until(lambda: steps().max() > 64, 'gaps')
    assert set(steps() % 64) == {0}
    emulator.clear()


def test_wrong_faults_answer_and_change_nothing(streaming):
    wrong = (
        {'name': 'gremlin'},
        {'name': 'drop', 'value': 3},
        {'name': 'drop', 'value': -1},
        {'name': 'sensor_nan', 'target': 'moon'},
    )
    for fields in wrong:
        answer = streaming.fault(**fields)
        assert not answer.accepted
        assert answer.message
    assert 'collision_stop' in streaming.fault('gremlin').message


@pytest.mark.parametrize('stop', ['collision_stop', 'e_stop', 'motors_off'])
def test_stops_latch_until_an_operator_starts_again(streaming, stop):
    emulator = streaming
    assert emulator.fault(stop).accepted
    emulator.operator.until(lambda: emulator.heard[-1].rapidExecState.state == 1, 'stopped')
    state = emulator.some(30)[-1]
    assert state.motorState.state == (1 if stop == 'collision_stop' else 2)
    assert state.mciState.state == (1 if stop == 'collision_stop' else 2)
    rest = np.array([m.planned.joints.joints for m in emulator.some(60)[30:]])
    assert np.ptp(rest, axis=0).max() == 0.0
    if stop != 'collision_stop':
        assert not emulator.ask('start_program').success
        assert emulator.ask('motors_on').success
    assert np.ptp([m.planned.joints.joints[0] for m in emulator.some(30)]) == 0.0
    assert emulator.ask('start_program').success
    emulator.operator.until(lambda: emulator.heard[-1].rapidExecState.state == 2, 'running')


def test_web_services_load_run_and_stop_a_program(streaming):
    emulator = streaming
    client = WebClient(emulator.web_port)
    load, execution = '/rw/rapid/tasks/T_ROB1?action=loadmod', '/rw/rapid/execution'
    assert client.ask('PUT', '/fileservice/$HOME/short.mod', SHORT.encode())[0] == 201
    path = {'modulepath': '$HOME/short.mod', 'replace': 'true'}
    assert client.ask('POST', load, path)[0] >= 400  # one is running
    assert client.state(execution)['ctrlexecstate'] == 'running'
    assert client.ask('POST', f'{execution}?action=stop', {'stopmode': 'stop'})[0] == 204
    assert client.state(execution)['ctrlexecstate'] == 'stopped'
    assert client.ask('POST', load, path)[0] == 200
    assert client.ask('POST', f'{execution}?action=resetpp')[0] == 204
    start = {'regain': 'continue', 'execmode': 'continue', 'cycle': 'once', 'condition': 'none'}
    # Manual, then automatic but not confirmed: refused.
    from std_srvs.srv import SetBool

    for key, mode in ((False, 'MANR'), (True, 'AUTO_CH')):
        emulator.operator.call('/abb_emulator/automatic', SetBool, data=key)
        assert client.state('/rw/panel/opmode')['opmode'] == mode
        assert client.ask('POST', f'{execution}?action=start', start)[0] >= 400
    assert emulator.ask('confirm_automatic').success
    assert client.state('/rw/panel/opmode')['opmode'] == 'AUTO'
    assert client.ask('POST', f'{execution}?action=start', start)[0] == 204
    emulator.operator.until(
        lambda: client.state(execution)['ctrlexecstate'] == 'stopped', 'the end of the program'
    )
    joints = client.state('/rw/motionsystem/mechunits/ROB_1/jointtarget')
    assert float(joints['rax_1']) == pytest.approx(1.0, abs=0.01)
    assert client.state('/rw/panel/ctrlstate')['ctrlstate'] == 'motoron'
    # By hand again: the file of the parameter.
    assert emulator.ask('load_module').success
    assert emulator.ask('start_program').success


def test_it_states_its_real_time_factor_and_ends_quietly(streaming, record_property):
    operator = streaming.operator

    def figures():
        found = [
            {item.key: item.value for item in status.values}
            for array in operator.diagnostics
            for status in array.status
            if 'abb_emulator' in status.name
        ]
        return found[-1] if found else {}

    operator.until(lambda: float(figures().get('plant_real_time_factor', 0)) > 0.0, 'factor')
    said = streaming.process.stop()
    assert 'real-time factor' in said
    assert 'Traceback' not in said
    record_property('said', said.strip().splitlines()[-1])
    print(said.strip().splitlines()[-1])
