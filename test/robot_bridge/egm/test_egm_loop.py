"""Bridge and emulated controller over real UDP, cycle by cycle: no clock decides the outcome."""

import math
import socket
import time

import numpy as np
import pytest

from abb_emulator.egm.egm_session import Phase
from benchmarks.faults.guided_arm import CYCLE_S
from modal_core.errors import BridgeError
from robot_bridge.egm.egm_link import EgmLink
from robot_bridge.egm.egm_messages import EgmSensor
from robot_bridge.egm.session_check import SessionCheck, SessionLimits
from robot_bridge.operator import FlowState
from test.support.egm_loop import Loop, sine


@pytest.fixture
def loop():
    loop = Loop()
    yield loop
    loop.close()


def test_guidance_starts_without_a_jump_and_plays_the_plan(loop):
    loop.run(20)
    assert loop.controller.session.phase == Phase.RUNNING
    assert loop.flow.state == FlowState.IDLE
    np.testing.assert_allclose(loop.planned[-1], loop.start_deg, atol=1e-9)
    loop.go(sine(loop, 5.0)).run(1100)
    assert loop.flow.state == FlowState.HOLDING
    travel = np.ptp(np.array(loop.measured), axis=0)
    assert 0.09 < travel[0] < 0.11
    assert travel[1:].max() < 1e-3
    assert loop.link.n_received == loop.link.n_sent


def test_one_reply_per_packet_and_no_queue_builds_up(loop):
    loop.run(300)
    assert loop.controller.client.n_queued <= 1
    assert loop.link.n_sent == loop.link.n_received == 300
    # The last reply waits for the next cycle.
    assert loop.controller.client.n_received in (299, 300)


@pytest.mark.parametrize('address', ['127.0.0.2', '127.0.0.3'])
def test_a_second_sender_latches_and_the_arm_comes_to_rest(loop, address):
    loop.run(20).go(sine(loop, 5.0)).run(400)
    copy = next(p.data for p in reversed(loop.packets) if not p.sent)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as spoof:
        spoof.bind((address, 0))
        spoof.sendto(copy, loop.link.address)
        for _ in range(200):
            if loop.flow.state == FlowState.ABORTED:
                break
            time.sleep(0.005)
    assert loop.flow.state == FlowState.ABORTED
    assert 'foreign_sender' in loop.flow.reason
    loop.run(120)
    still = np.array(loop.planned)[-60:]
    assert np.ptp(still, axis=0).max() < 2e-3


def test_a_replayed_packet_gets_no_answer(loop):
    loop.run(50)
    sent = loop.link.n_sent
    old = [p.data for p in loop.packets if not p.sent][10]
    # From the controller's own port: only the sequence number gives it away.
    loop.controller.client.send(old, 0.0)
    deadline = time.monotonic() + 2.0
    while not loop.link.check.counts['out_of_order'] and time.monotonic() < deadline:
        time.sleep(0.002)
    assert loop.link.check.counts['out_of_order'] == 1
    assert loop.link.n_sent == sent


def test_fuzzed_datagrams_neither_move_nor_stop_the_bridge(loop):
    random = np.random.default_rng(11)
    loop.run(30)
    good = [p.data for p in loop.packets if not p.sent][-1]
    before = loop.link.check.counts['malformed']
    for _ in range(300):
        data = bytearray(good[: random.integers(0, len(good))])
        for _ in range(3):
            if data:
                data[random.integers(len(data))] = random.integers(256)
        loop.controller.client.send(bytes(data), 0.0)
        time.sleep(1e-4)
    time.sleep(0.1)
    assert loop.link.check.counts['malformed'] > before + 200
    loop.run(30)
    assert loop.flow.state == FlowState.IDLE
    np.testing.assert_allclose(loop.planned[-1], loop.start_deg, atol=1e-9)


def test_emulator_survives_fuzzed_replies(loop):
    random = np.random.default_rng(12)
    loop.run(30)
    session = loop.controller.session
    for _ in range(300):
        session.hear(random.bytes(random.integers(0, 120)))
    good = [p.data for p in loop.packets if p.sent][-1]
    for _ in range(300):
        data = bytearray(good)
        data[random.integers(len(data))] = random.integers(256)
        session.hear(bytes(data))
    assert session.n_bad > 100
    loop.run(5)


def test_link_loss_ends_in_error_within_comm_timeout_and_nothing_resumes(loop):
    loop.run(20).go(sine(loop, 10.0, amplitude_deg=0.1)).run(400)
    loop.faults.sensor.drop = 1.0
    lost = len(loop.planned)
    loop.run(200)
    assert loop.controller.session.phase == Phase.ERROR
    planned = np.array(loop.planned)
    moving = np.flatnonzero(np.abs(np.diff(planned[:, 0])) > 0)
    # CommTimeout 0.1 s and the stop ramp 0.1 s.
    assert (moving[-1] - lost) * CYCLE_S < 0.1 + 0.1 + 5 * CYCLE_S
    assert loop.flow.state == FlowState.ABORTED
    loop.faults.clear()
    loop.run(100)
    assert loop.controller.session.phase == Phase.ERROR
    assert not loop.controller.running
    assert np.ptp(np.array(loop.planned)[-100:], axis=0).max() == 0.0


def test_emergency_stop_latches_on_both_sides(loop):
    loop.run(20).go(sine(loop, 5.0)).run(400)
    loop.controller.emergency_stop()
    loop.run(60)
    assert loop.flow.state == FlowState.ABORTED
    assert not loop.controller.switch_motors_on()
    with pytest.raises(BridgeError):
        loop.flow.start(time.monotonic(), '')
    assert np.ptp(np.array(loop.planned)[-40:], axis=0).max() == 0.0


def test_dropped_packets_are_counted_and_a_few_are_survived(loop):
    loop.run(20).go(sine(loop, 5.0))
    loop.faults.sensor.drop = 0.02
    loop.run(600)
    assert loop.flow.state == FlowState.RUNNING
    assert loop.controller.session.phase == Phase.RUNNING


def test_wildcard_addresses_are_refused():
    check = SessionCheck(SessionLimits())
    for address in ('0.0.0.0', '', '::'):
        with pytest.raises(BridgeError, match='one interface'):
            EgmLink(address, 0, check, lambda *_: None, lambda _: None, lambda _: None)


def test_the_controller_listens_to_one_port_of_the_sensor_only(loop):
    from robot_bridge.egm.egm_command import encode_sensor

    loop.run(100)
    port = loop.controller.client.address
    away = (loop.start_deg + 3.0).tolist()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(('127.0.0.1', 0))
        for number in range(100):
            other.sendto(encode_sensor(number, number, away, [5.0] * 6), port)
            loop.run(1)
    assert np.abs(np.array(loop.planned) - loop.start_deg).max() < 1e-9
    assert loop.controller.client.n_foreign >= 99


@pytest.mark.parametrize('far', [math.nan, math.inf, -1e300, 1e308])
@pytest.mark.parametrize('as_speed', [False, True])
def test_references_no_law_can_follow_move_nothing(loop, far, as_speed):
    loop.run(50)
    session, before = loop.controller.session, loop.controller.axes.planned_deg.copy()
    reply = EgmSensor()
    reply.header.seqno, reply.header.tm, reply.header.mtype = 50, 200, 3
    reply.planned.joints.joints.extend([far] * 6 if not as_speed else before.tolist())
    reply.speedRef.joints.joints.extend([far] * 6 if as_speed else [0.0] * 6)
    assert session.hear(reply.SerializeToString()) is None
    assert session.n_bad == 1
    assert loop.run(50).planned[-1] == pytest.approx(before, abs=1e-6)
