"""Every fault of the list, seen where it must show: on the wire or in the samples."""

import socket

import numpy as np
import pytest

from abb_emulator.cell import ArmSide, CellSettings, MotorSide
from abb_emulator.egm.guidance_law import GuidanceSettings
from abb_emulator.egm.link_faults import LinkFaults
from abb_emulator.egm.udp_client import UdpClient
from abb_emulator.node.fault_desk import Fault, FaultDesk, KINDS
from abb_emulator.rapid.rapid_parser import parse_module
from abb_emulator.rapid.rapid_program import RapidProgram
from modal_core.errors import BridgeError
from structural_model.robot_files import load_layout

CYCLE_S = 0.004032
SEED = 11
STREAM = """MODULE Stream
  CONST jointtarget jA:=[[5,45,-10,90,-90,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  VAR egmident e;
  PROC main()
    EGMGetId e;
    EGMSetupUC ROB_1,e,"default","UCdevice"\\Joint\\CommTimeout:=0.1;
    EGMStreamStart e\\SampleRate:=4;
    MoveAbsJ jA\\NoEOffs,v50,fine,tool0;
    WaitTime 60;
  ENDPROC
ENDMODULE
"""


class Wire:
    """A streaming controller and a plain socket that listens to it."""

    def __init__(self, model, start_deg, peers):
        self.peers = peers
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(('127.0.0.1', 0))
        self.socket.setblocking(False)
        self.faults = LinkFaults(np.random.default_rng(SEED))
        client = UdpClient(self.socket.getsockname(), self.faults, '127.0.0.1')
        settings = CellSettings(seed=SEED)
        self.motors = MotorSide(model, start_deg, client, settings, 100.0)
        self.controller = self.motors.controller
        channels = load_layout('irb6660_205_190', 'sensors').channels
        self.arm = ArmSide(model, channels, start_deg, settings)
        names = tuple(channel.name for channel in channels)
        self.desk = FaultDesk(self.controller, self.faults, self.arm.sensors, names)
        program = RapidProgram(
            parse_module(STREAM), self.controller, GuidanceSettings(),
            np.random.default_rng(SEED),
        )  # fmt: skip
        self.controller.start(program.run())
        self.heard, self.blocks = [], []

    def cycles(self, n, arm=False):
        """Run some cycles and return what came over the wire in them."""
        first = len(self.heard)
        for _ in range(n):
            self.desk.tick(CYCLE_S)
            motion = self.motors.cycle()
            if arm:
                self.blocks += self.arm.take(motion)
            while True:
                try:
                    data = self.socket.recv(4096)
                except BlockingIOError:
                    break
                self.heard.append(self.peers.EgmRobot.FromString(data))
        return self.heard[first:]

    def numbers(self, n):
        return [message.header.seqno for message in self.cycles(n)]

    def close(self):
        self.controller.client.close()
        self.socket.close()


@pytest.fixture
def wire(model, start_deg, peers):
    made = Wire(model, start_deg, peers)
    yield made
    made.close()


def test_stream_sends_every_cycle_during_a_move_and_ignores_replies(wire, peers):
    first = wire.cycles(5)
    address = wire.socket.getsockname()
    found = wire.cycles(300)
    assert [m.header.seqno for m in first + found] == list(range(len(first) + len(found)))
    assert {m.mciState.state for m in found} == {2}
    assert {m.rapidExecState.state for m in found} == {2}
    times = np.array([m.feedBack.time.sec * 10**6 + m.feedBack.time.usec for m in found])
    np.testing.assert_allclose(np.diff(times), 4032, atol=1)
    joints = np.array([m.feedBack.joints.joints[0] for m in found])
    assert np.ptp(joints) > 1.0
    # A reply that asks for something else, from the peer's own port, moves nothing.
    reply = peers.EgmSensor()
    reply.header.seqno, reply.header.tm, reply.header.mtype = 0, 0, 3
    reply.planned.joints.joints.extend([50.0] * 6)
    reply.speedRef.joints.joints.extend([50.0] * 6)
    local = wire.controller.client.address
    before = wire.controller.axes.planned_deg[1:].copy()
    for _ in range(20):
        wire.socket.sendto(reply.SerializeToString(), ('127.0.0.1', local[1]))
        wire.cycles(1)
    np.testing.assert_array_equal(wire.controller.axes.planned_deg[1:], before)
    assert address == wire.controller.client.remote


def test_drop_duplicate_reorder_and_delay(wire):
    wire.cycles(10)
    wire.desk.put(Fault('drop', 0.5, 0.0, 'robot'))
    numbers = wire.numbers(400)
    assert 140 < len(numbers) < 260, f'seed {SEED}'
    wire.desk.put(Fault('clear'))
    assert len(wire.numbers(50)) == 50
    wire.desk.put(Fault('duplicate', 1.0))
    numbers = wire.numbers(20)
    assert numbers[0::2] == numbers[1::2]
    assert len(numbers) == 40
    wire.desk.put(Fault('clear'))
    wire.desk.put(Fault('reorder', 1.0))
    numbers = wire.numbers(20)
    assert sorted(numbers) == list(range(min(numbers), min(numbers) + 20))
    assert numbers != sorted(numbers)
    wire.desk.put(Fault('clear'))
    wire.desk.put(Fault('delay', 0.04))
    assert len(wire.numbers(10)) == 0  # 40 ms are 9.9 cycles
    assert len(wire.numbers(10)) == 10


def test_a_fault_ends_by_itself(wire):
    wire.cycles(5)
    wire.desk.put(Fault('drop', 1.0, 0.2))
    assert wire.desk.active
    assert len(wire.cycles(int(0.19 / CYCLE_S))) == 0
    wire.cycles(5)
    assert not wire.desk.active
    assert len(wire.cycles(20)) == 20


def test_clock_skew_restart_and_undefined(wire):
    wire.cycles(20)
    wire.desk.put(Fault('clock_skew', 0.008))
    found = wire.cycles(100)
    times = np.array([m.feedBack.time.sec * 10**6 + m.feedBack.time.usec for m in found])
    assert np.mean(np.diff(times)) == pytest.approx(4032 * 1.008, rel=1e-4)
    wire.desk.put(Fault('restart_session'))
    assert wire.numbers(3) == [0, 1, 2]
    wire.desk.put(Fault('rapid_undefined', duration_s=0.04))
    states = [m.rapidExecState.state for m in wire.cycles(20)]
    assert states[0] == 0
    assert states[-1] == 2


@pytest.mark.parametrize('name', ['e_stop', 'collision_stop', 'motors_off'])
def test_stops_bring_the_axes_to_rest_and_nothing_resumes(wire, name):
    wire.cycles(100)
    assert np.abs(wire.controller.axes.planned_speed_deg_s).max() > 0.0
    wire.desk.put(Fault(name))
    wire.cycles(60)
    state = wire.cycles(1)[0]
    assert state.rapidExecState.state == 1
    assert state.motorState.state == (1 if name == 'collision_stop' else 2)
    assert state.mciState.state == (1 if name == 'collision_stop' else 2)
    wire.desk.put(Fault('clear'))
    rest = np.array([m.feedBack.joints.joints for m in wire.cycles(250)])
    assert np.ptp(rest, axis=0).max() < 1e-3
    if name == 'e_stop':
        assert not wire.controller.switch_motors_on()


@pytest.mark.parametrize('name', [k.name for k in KINDS if k.name.startswith('sensor_')])
def test_sensor_faults_spoil_the_channels_named_and_no_other(wire, name):
    target = wire.arm.arm.channels[4].name
    wire.cycles(40, arm=True)
    wire.desk.put(Fault(name, 0.05 if name == 'sensor_clipping' else 0.0, 0.0, target))
    first = len(wire.blocks)
    wire.cycles(120, arm=True)
    data = np.concatenate([block.acceleration for block in wire.blocks[first:]])
    spoilt = data[:, 4]
    assert np.isfinite(np.delete(data, 4, axis=1)).all()
    assert np.delete(data, 4, axis=1).std(axis=0).min() > 0.0
    if name == 'sensor_nan':
        assert 0.05 < np.isnan(spoilt).mean() < 0.15, f'seed {SEED}'
    elif name == 'sensor_dropout':
        assert not spoilt.any()
    elif name == 'sensor_flatline':
        assert np.ptp(spoilt) == 0.0
    elif name == 'sensor_clipping':
        assert max(np.ptp(b.acceleration[:, 4]) for b in wire.blocks[first:]) < 0.1001
    else:
        assert np.ptp(spoilt) > 40.0


def test_lost_blocks_leave_a_jump_in_the_index(wire):
    wire.desk.put(Fault('block_dropout', 0.5))
    wire.cycles(400, arm=True)
    steps = np.diff([block.first_index for block in wire.blocks])
    assert set(steps % 64) == {0}
    assert steps.max() > 64


def test_unknown_faults_answer_with_the_list(wire):
    with pytest.raises(BridgeError) as caught:
        wire.desk.put(Fault('gremlins'))
    for kind in KINDS:
        assert kind.name in str(caught.value)
    for wrong in (
        Fault('drop', 1.5), Fault('drop', -0.1), Fault('drop', float('nan')),
        Fault('drop', 0.5, -1.0), Fault('drop', 0.5, 0.0, 'moon'), Fault('nan', 0.5, 0.0, 'moon'),
    ):  # fmt: skip
        with pytest.raises(BridgeError):
            wire.desk.put(wrong)
    assert not wire.desk.active
