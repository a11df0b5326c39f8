"""Life cycle and backends of the bridge's process: who may move what, when nothing answers."""

import resource
import signal
import socket
import time

from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from mcap.reader import make_reader
import numpy as np
import pytest

pytestmark = pytest.mark.node
DISCONNECTED, IDLE, ARMED, RUNNING, HOLDING, ABORTED = 0, 1, 2, 3, 5, 6
CALM = {'link_timeout_s': 2.0, 'heartbeat_timeout_s': 2.0, 'dry_run': False}
REAL = {'link_timeout_s': 0.4, 'heartbeat_timeout_s': 0.4}  # as calm as a real arm may be


@pytest.fixture
def port(drivers):
    return drivers.free_port()


@pytest.fixture
def peer(peers, start_deg, port):
    made = peers.StrictPeer(start_deg, ('127.0.0.1', port))
    yield made
    made.close()


@pytest.fixture
def bridge(drivers, domain, operator, port):
    """Return a function that starts a bridge; it is stopped after the test."""
    running = []

    def start(limits=None, **parameters):
        operator.states.clear()
        made = drivers.NodeProcess(
            'robot_bridge', domain, limits=limits, port=port, **{**CALM, **parameters}
        )
        running.append(made)
        operator.until(lambda: operator.states, 'state')
        return made

    yield start
    for item in running:
        assert 'Traceback' not in item.stop()


def change(operator, transition):
    return operator.call(
        '/robot_bridge/change_state', ChangeState, transition=Transition(id=transition)
    ).success


def test_life_cycle_from_nothing_to_motion_and_back(bridge, peer, operator, message):
    bridge(autostart=False)
    operator.hold()
    assert operator.last.reason == 'not configured'
    assert 'not configured' in operator.arm('0' * 64).message
    operator.plans.publish(message)  # kept until there is something to play it
    peer.expect_reply = False
    peer.start()
    time.sleep(0.2)
    assert peer.replies == []
    # Inactive: it hears, publishes joints, takes a plan, and neither answers nor arms.
    assert change(operator, Transition.TRANSITION_CONFIGURE)
    operator.until_connected()
    operator.until(lambda: operator.last.plan_hash == message.plan_hash, 'plan')
    assert 'not active' in operator.arm(message.plan_hash).message
    assert peer.replies == []
    seen = len(operator.joints)
    operator.until(lambda: len(operator.joints) > seen + 20, 'joint states')
    # Active: every packet is answered.
    assert change(operator, Transition.TRANSITION_ACTIVATE)
    operator.until(lambda: peer.replies, 'replies')
    peer.expect_reply = True
    assert operator.arm(message.plan_hash).accepted
    assert operator.start().success
    operator.until(lambda: operator.last.progress > 0.25, 'progress')
    # Deactivated in motion: slows down, holds, then is silent and stays latched.
    peer.patience_s = 0.05
    assert change(operator, Transition.TRANSITION_DEACTIVATE)
    seen = len(peer.history)
    operator.until(lambda: len(peer.history) > seen + 10, 'cycles')
    assert peer.history[-1][2] is None
    last = peer.replies[-1]
    assert not any(last.speedRef.joints.joints), 'the last reply must ask for standstill'
    assert len({item[1] for item in peer.history[seen:]}) == 1
    operator.until_state(ABORTED)
    assert peer.faults == []
    assert change(operator, Transition.TRANSITION_ACTIVATE)
    operator.until_state(ABORTED)
    assert not operator.arm(message.plan_hash).accepted
    # Cleaned up, the port is free again.
    assert change(operator, Transition.TRANSITION_DEACTIVATE)
    assert change(operator, Transition.TRANSITION_CLEANUP)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(peer.bridge)
    state = operator.call('/robot_bridge/get_state', GetState).current_state
    assert state.label == 'unconfigured'


def test_guidance_of_a_real_arm_must_be_enabled(bridge, drivers, domain, operator, port):
    for parameters in (
        {'backend': 'abb_egm'},
        {'backend': 'emulator', 'controller_address': '192.168.125.1'},
    ):
        process = drivers.NodeProcess(
            'robot_bridge', domain, port=port, **{**CALM, **REAL, **parameters}
        )
        said = process.process.communicate(timeout=60.0)[1]
        assert process.process.returncode == 2, said
        assert 'guidance is not enabled' in said
        assert len(said.strip().splitlines()) == 1
    bridge(backend='abb_egm', guidance_enabled=True, **REAL)
    assert operator.last.backend == 'abb_egm'


@pytest.mark.parametrize(
    ('parameters', 'words'),
    [
        ({'backend': 'replay'}, 'start replay'),
        ({'backend': 'kuka'}, 'abb_egm'),
        ({'method': 'magic'}, 'rapid'),
        ({'bind_address': '0.0.0.0'}, 'one interface'),
    ],
)
def test_bad_set_ups_end_in_one_line(drivers, domain, port, parameters, words):
    process = drivers.NodeProcess('robot_bridge', domain, port=port, **{**CALM, **parameters})
    said = process.process.communicate(timeout=60.0)[1]
    assert process.process.returncode == 2, said
    assert words in said and len(said.strip().splitlines()) == 1


def test_a_port_in_use_is_said_in_one_line(drivers, domain):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(('127.0.0.1', 0))
        process = drivers.NodeProcess('robot_bridge', domain, port=other.getsockname()[1], **CALM)
        said = process.process.communicate(timeout=60.0)[1]
    assert process.process.returncode == 2, said
    assert f'127.0.0.1:{process.parameters["port"]}: cannot listen: Address already in use' in said
    assert len(said.strip().splitlines()) == 1


def test_rapid_follows_the_program_and_answers_nothing(
    bridge, peer, operator, message, pulses, tmp_path, start_deg
):
    path = tmp_path / 'plan.mod'
    bridge(backend='abb_rapid', rapid_file=str(path), **REAL)
    operator.plans.publish(message)
    operator.until(
        lambda: any('PLAN_REFUSED' in code for code in operator.codes('bridge')), 'refusal'
    )
    operator.hold().offer(pulses)
    operator.until(path.exists, 'module')
    assert pulses.plan_hash in path.read_text()
    assert not operator.arm('0' * 64).accepted
    # No stream before the program: a plan can be armed all the same.
    assert operator.arm(pulses.plan_hash).accepted
    assert operator.start().success
    operator.until_state(RUNNING)
    assert 'pendant' in operator.last.reason
    peer.expect_reply, peer.state['mci'] = False, 2
    peer.start()
    operator.until(lambda: 'is running' in operator.last.reason, 'running')
    operator.until(lambda: operator.last.progress > 0.95, 'progress')
    peer.state['rapid'] = 1
    operator.until_state(HOLDING)
    assert operator.last.n_sent == 0
    assert peer.replies == []
    # A program that ends early is a fault.
    assert operator.arm(pulses.plan_hash).accepted
    assert operator.start().success
    peer.state['rapid'] = 2
    operator.until(lambda: 'is running' in operator.last.reason, 'running')
    peer.pause()
    operator.until_state(ABORTED)
    assert 'link lost' in operator.last.reason


@pytest.mark.slow
def test_rapid_is_loaded_run_and_stopped_by_web_services(
    bridge, drivers, domain, operator, pulses, tmp_path, port
):
    web = drivers.free_port()
    emulator = drivers.NodeProcess(
        'abb_emulator', domain, sensor_port=port, start_program=False, rws__port=web
    )
    try:
        bridge(
            method='rapid',
            rapid_file=str(tmp_path / 'plan.mod'),
            rws_address=f'127.0.0.1:{web}',
        )
        operator.hold().offer(pulses)
        operator.until(lambda: 'abb_emulator' in operator.node.get_node_names(), 'emulator')
        time.sleep(1.0)
        assert operator.arm(pulses.plan_hash).accepted
        answer = operator.start()
        assert answer.success, answer.message
        operator.until(lambda: 'is running' in operator.last.reason, 'running')
        places = [np.array(item.position) for item in operator.joints[-1:]]
        operator.until_state(HOLDING)
        places += [np.array(item.position) for item in operator.joints]
        assert np.ptp(places, axis=0).max() > 1e-3
        assert operator.last.n_sent == 0
        # Again, and the heartbeat is let go: the program is stopped.
        assert operator.arm(pulses.plan_hash).accepted
        answer = operator.start()
        assert answer.success, answer.message
        operator.until(lambda: operator.last.progress > 0.2, 'progress')
        operator.hold(False)
        operator.until_state(ABORTED)
        assert 'heartbeat' in operator.last.reason
        assert 'NOT STOPPED' not in operator.last.reason
        seen = len(operator.joints)
        time.sleep(1.0)
        operator.hold()
        last = np.array([item.position for item in operator.joints[seen:]][-50:])
        assert len(last) == 0 or np.ptp(last, axis=0).max() < 1e-4
        assert operator.last.state == ABORTED
    finally:
        assert 'Traceback' not in emulator.stop()


@pytest.mark.slow
def test_a_full_disk_ends_the_log_and_nothing_else(
    bridge, peer, operator, message, tmp_path, peers
):
    def small_files():
        # Python ignores SIGXFSZ, so that the write fails as it does on a full disk.
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (600_000, 600_000))

    path = tmp_path / 'egm.mcap'
    bridge(limits=small_files, packet_log=str(path))
    operator.hold()
    peer.start()
    operator.until_connected()
    operator.diagnostics.clear()
    operator.until(
        lambda: any(code.startswith('PACKET_LOG_STOPPED') for code in operator.codes('bridge')),
        'diagnostic',
        90.0,
    )
    # The file has its name and is readable at once, although nothing was closed.
    with path.open('rb') as file:
        records = [item[2].data for item in make_reader(file).iter_messages(log_time_order=False)]
    assert len(records) > 500
    peers.EgmRobot.FromString(records[0])
    # The link goes on, and a plan can still be played.
    operator.offer(message)
    assert operator.arm(message.plan_hash).accepted
    assert operator.start().success
    operator.until(lambda: operator.last.progress > 0.1, 'progress')
    assert operator.last.state == RUNNING
    assert peer.faults == []
    assert np.isfinite(operator.last.reply_latency_p99_s)
