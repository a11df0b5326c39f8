"""The bridge as a process, against a controller that shares no code with it."""

from array import array
import socket
import time

from hypothesis import given, HealthCheck, settings
from hypothesis import strategies as st
import numpy as np
import pytest

pytestmark = pytest.mark.node
DISCONNECTED, IDLE, ARMED, RUNNING, HOLDING, ABORTED = 0, 1, 2, 3, 5, 6
TIMEOUT_S = 2.0  # of link and heartbeat: a busy machine is no lost link
STOP_RAMP_CYCLES = 37  # 0.15 s: the shipped ramp of 0.05 s and what control adds


class Rig:
    """A bridge process, a strict peer and an operator."""

    def __init__(self, peers, processes, operator, drivers, start_deg, **parameters):
        self.port = drivers.free_port()
        self.operator, self.start_deg = operator, start_deg
        operator.states.clear()  # of the process before
        self.process = processes(
            'robot_bridge',
            port=self.port,
            **{
                'dry_run': False,
                'link_timeout_s': TIMEOUT_S,
                'heartbeat_timeout_s': TIMEOUT_S,
                **parameters,
            },
        )
        self.peer = peers.StrictPeer(start_deg, ('127.0.0.1', self.port))

    def ready(self):
        """Be connected, with nothing latched, at the start pose, with a heartbeat."""
        operator, peer = self.operator, self.peer
        peer.state.update(motors=1, mci=3, rapid=2)
        if not peer.running:
            peer.start()
        operator.hold().until_connected()
        if operator.last.state in (ARMED, RUNNING):
            operator.abort()
            operator.until_state(ABORTED)
        if operator.last.state == ABORTED:
            operator.until(lambda: operator.reset().success)
        self.drift_to(self.start_deg)
        operator.until_state(IDLE if operator.last.state != HOLDING else HOLDING)
        peer.n_silent = 0
        return self

    def drift_to(self, angles):
        """Move the arm by hand, guidance stopped, slower than any axis can go."""
        peer = self.peer
        peer.state['mci'] = 2
        self.cycles(3)
        while (left := np.array(angles) - peer.joints_deg).any():
            step = np.clip(left, -0.05, 0.05)
            peer.joints_deg = list(np.array(peer.joints_deg) + step)
            self.cycles(1)
        self.cycles(3)
        peer.state['mci'] = 3
        self.cycles(3)

    def cycles(self, n):
        """Let n whole cycles pass: what the peer says has reached the bridge."""
        seen = len(self.peer.history)
        self.operator.until(lambda: len(self.peer.history) > seen + n, 'cycles', pause_s=0.001)

    def running(self, message):
        """Be in motion, past the ramp-in."""
        operator = self.ready().operator
        operator.offer(message)
        assert operator.arm(message.plan_hash).accepted
        answer = operator.start()
        assert answer.success, answer.message
        operator.until(
            lambda: operator.last.progress > 0.2 or operator.last.state == ABORTED, 'progress'
        )
        assert operator.last.state == RUNNING, operator.last.reason
        return self

    def speeds(self):
        """Return the largest speed asked for in each answered cycle so far [deg/s]."""
        return np.array([max(map(abs, item[2])) for item in self.peer.history if item[2]])

    def at_rest(self):
        """Assert that the arm, once slowed down, stands still, answered cycle by cycle."""
        self.cycles(STOP_RAMP_CYCLES)
        seen = len(self.peer.history)
        self.cycles(60)
        places = np.array([item[1] for item in self.peer.history[seen:]])
        assert np.ptp(places, axis=0).max() == 0.0


@pytest.fixture(scope='module')
def rig(peers, processes, operator, drivers, start_deg):
    made = Rig(peers, processes, operator, drivers, start_deg)
    yield made
    made.peer.close()
    assert 'Traceback' not in made.process.stop()


@pytest.fixture
def ready(rig):
    yield rig.ready()
    assert rig.peer.faults == []
    assert rig.peer.n_silent == 0


def test_nothing_starts_without_plan_arm_hash_and_time(ready, message):
    operator = ready.operator
    assert 'no plan' in operator.arm('0' * 64).message
    assert 'not armed' in operator.start().message
    operator.offer(message)
    wrong = operator.arm('0' * 64)
    assert not wrong.accepted and message.plan_hash[:16] in wrong.message
    for timeout_s in (0.0, -1.0, 301.0, float('nan')):
        assert 'timeout_s' in operator.arm(message.plan_hash, timeout_s).message
    assert 'not armed' in operator.start().message
    assert operator.arm(message.plan_hash, 0.2).accepted
    operator.until_state(IDLE)
    refused = operator.start()
    assert not refused.success and 'timed out' in refused.message
    assert not ready.speeds().any()


def test_a_plan_without_measure_is_refused_before_it_is_checked(ready, message):
    from oma_msgs.msg import ExcitationPlan

    operator = ready.operator
    operator.offer(message)
    for n_samples, period_s, word in ((160_000, 0.004, 'n_samples'), (20_000, 0.2, 'duration_s')):
        still = array('d', bytes(8 * 6 * n_samples))
        operator.diagnostics.clear()
        operator.plans.publish(
            ExcitationPlan(
                joint_names=message.joint_names, robot_name=message.robot_name,
                signal=message.signal, sample_period_s=period_s, n_samples=n_samples,
                position=still, velocity=still,
            )
        )  # fmt: skip
        operator.until(
            lambda word=word: any(
                f'PLAN_REFUSED ExcitationPlan.{word}: too long' in text
                for text in operator.codes('robot_bridge')
            ),
            'refusal',
        )
    assert operator.last.plan_hash == message.plan_hash


def test_start_is_refused_without_heartbeat(ready, message):
    operator = ready.operator
    operator.offer(message)
    operator.hold(False)
    time.sleep(TIMEOUT_S + 0.2)
    assert operator.arm(message.plan_hash).accepted
    refused = operator.start()
    assert not refused.success and 'heartbeat' in refused.message
    assert not ready.speeds().any()


def test_start_is_refused_away_from_the_start_pose(ready, message):
    operator = ready.operator
    operator.offer(message)
    ready.drift_to(ready.start_deg + np.array([0.0, 0.0, 0.5, 0.0, 0.0, 0.0]))
    assert operator.arm(message.plan_hash).accepted
    refused = operator.start()
    assert not refused.success and 'axis 3' in refused.message
    assert not ready.speeds().any()


@pytest.mark.parametrize(
    ('state', 'word'),
    [({'motors': 2}, 'motors'), ({'mci': 2}, 'session'), ({'rapid': 1}, 'RAPID')],
)
def test_start_is_refused_when_the_controller_is_not_ready(ready, message, state, word):
    operator = ready.operator
    operator.offer(message)
    assert operator.arm(message.plan_hash).accepted
    ready.peer.state.update(state)
    ready.cycles(3)
    refused = operator.start()
    assert not refused.success and word in refused.message
    assert not ready.speeds().any()


def test_a_plan_is_played_as_planned_and_every_reply_is_strict(ready, message, plan, model):
    operator, peer = ready.operator, ready.peer
    operator.offer(message)
    assert operator.arm(message.plan_hash).accepted
    begin = len(peer.history)
    assert operator.start().success
    operator.until_state(HOLDING)
    ready.at_rest()
    cells = [item for item in peer.history[begin:] if item[2]]
    found = np.array([item[1] for item in cells])
    moving = np.flatnonzero([any(item[2]) for item in cells])
    # The peer integrates position plus speed: it stands where the plan is at the cycle's end.
    times = (np.arange(len(found)) - moving[0] + 1) * 0.004032
    path = plan.trajectory.position_spline(np.clip(times, 0.0, plan.duration_s))
    wanted = np.degrees([model.to_controller(row) for row in path])
    after = (times > 1.1) & (times < plan.duration_s)
    np.testing.assert_allclose(found[after], wanted[after], atol=1e-9)
    assert abs(len(moving) * 0.004032 - plan.duration_s) < 0.05
    # Radians and serial joints on the topic, motor-side degrees on the wire.
    last = np.degrees(model.to_controller(operator.joints[-1].position))
    np.testing.assert_allclose(last, peer.joints_deg, atol=1e-6)


@pytest.mark.slow
def test_a_plan_that_comes_during_a_run_waits_for_its_end_and_its_own_release(rig, model, message):
    from excitation_planner.planner import plan_excitation
    from excitation_planner.request import PlanRequest
    from excitation_planner.ros_messages import plan_to_message
    from structural_model.robot_files import load_layout

    request = PlanRequest(
        seed=2, signal='band_limited_noise', duration_s=6.0,
        start_position=tuple(model.pose('P1').tolist()),
    )  # fmt: skip
    layout = load_layout('irb6660_205_190', 'sensors')
    other = plan_to_message(plan_excitation(model, layout, request))
    operator = rig.running(message).operator
    seen, n_codes = len(operator.states), len(operator.codes('bridge'))
    operator.plans.publish(other)
    operator.until(lambda: operator.last.state != RUNNING, 'end')
    operator.until(lambda: operator.last.plan_hash == other.plan_hash, 'the other plan')
    during = [state for state in operator.states[seen:] if state.plan_hash == message.plan_hash]
    assert {state.state for state in during} == {RUNNING, HOLDING}
    assert not any('REFUSED' in code for code in operator.codes('bridge')[n_codes:])
    assert operator.last.state == IDLE
    assert 'not armed' in operator.start().message
    rig.drift_to(rig.start_deg)
    assert operator.arm(other.plan_hash).accepted
    assert operator.start().success


def test_abort_stops_latches_and_reset_moves_nothing(rig, message, record_property):
    operator = rig.running(message).operator
    assert operator.abort().success
    before = len(rig.speeds())  # cycles since the answer, which a busy machine may bring late
    operator.until_state(ABORTED)
    rig.at_rest()
    cycles = int(np.flatnonzero(rig.speeds()).max()) - before
    record_property('abort_to_standstill_ms', 4.032 * cycles)
    assert cycles < STOP_RAMP_CYCLES
    assert 'ABORTED' in operator.arm(message.plan_hash).message
    assert not operator.start().success
    assert operator.reset().success
    operator.until_state(IDLE)
    assert 'not armed' in operator.start().message
    rig.at_rest()
    assert rig.peer.faults == []


@pytest.mark.parametrize('address', ['127.0.0.2', '127.0.0.3', '127.0.0.1'])
def test_a_second_sender_latches(rig, message, address):
    operator = rig.running(message).operator
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as spoof:
        spoof.bind((address, 0))
        spoof.settimeout(0.2)
        spoof.sendto(rig.peer.packet(), rig.peer.bridge)
        with pytest.raises(TimeoutError):
            spoof.recv(100)
    operator.until_state(ABORTED)
    assert '_sender' in operator.last.reason and address in operator.last.reason
    rig.at_rest()
    assert rig.peer.faults == []


def test_old_packets_get_no_answer_and_change_nothing(rig, message):
    operator, peer = rig.running(message).operator, rig.peer
    rejected = operator.last.n_rejected
    peer.pause()
    for seqno in (peer.seqno - 1, peer.seqno - 5, 1):
        peer.socket.sendto(
            peer.packet(seqno=seqno, tm=round(seqno * 4.032), joints=[0.0] * 6), peer.bridge
        )
    peer.socket.settimeout(0.1)
    with pytest.raises(TimeoutError):
        peer.socket.recv(4096)
    peer.start()
    operator.until(lambda: operator.last.n_rejected >= rejected + 3, 'rejected')
    assert operator.last.state == RUNNING
    assert peer.faults == []


def test_a_jump_no_axis_can_make_latches(rig, message):
    operator, peer = rig.running(message).operator, rig.peer
    peer.pause()
    peer.joints_deg[1] += 5.0
    peer.expect_reply = False
    peer.run(1)
    peer.expect_reply = True
    peer.start()
    operator.until_state(ABORTED)
    assert 'joint_jump' in operator.last.reason
    # Held where it is now, not pulled back to where it was.
    rig.at_rest()
    assert peer.faults == []


def test_a_stopped_controller_latches_and_is_never_resumed(rig, message):
    operator, peer = rig.running(message).operator, rig.peer
    peer.state.update(motors=2, mci=2, rapid=1)
    operator.until_state(ABORTED)
    peer.state.update(motors=1, mci=3, rapid=2)
    rig.at_rest()
    assert operator.last.state == ABORTED
    assert 'motors' in operator.last.reason


def test_a_silent_link_latches_and_is_never_resumed(rig, message):
    operator, peer = rig.running(message).operator, rig.peer
    peer.pause()
    operator.until_state(ABORTED)
    assert 'link lost' in operator.last.reason
    peer.start()
    operator.until_connected()
    rig.at_rest()
    assert operator.last.state == ABORTED
    assert peer.faults == []


def test_speed_override_is_ramped_and_bad_values_are_refused(rig, message):
    from rcl_interfaces.msg import Parameter, ParameterValue
    from rcl_interfaces.srv import SetParameters, SetParametersAtomically

    operator = rig.running(message).operator

    def fraction(value):
        return Parameter(name='speed_override', value=ParameterValue(type=3, double_value=value))

    def override(value):
        return operator.call(
            '/robot_bridge/set_parameters', SetParameters, parameters=[fraction(value)]
        ).results[0]

    # Together with one that is refused it is refused too, and nothing changes.
    port = Parameter(name='port', value=ParameterValue(type=2, integer_value=1))
    answer = operator.call(
        '/robot_bridge/set_parameters_atomically',
        SetParametersAtomically,
        parameters=[fraction(0.0), port],
    )
    assert not answer.result.successful
    for _ in range(2):
        assert operator.until_state(RUNNING).speed_override == 1.0

    assert not override(1.5).successful
    assert not override(float('nan')).successful
    assert override(0.0).successful
    operator.until(lambda: operator.last.speed_override == 0.0)
    steps = np.abs(np.diff(rig.speeds()))
    operator.until(lambda: operator.last.progress > 0.5, 'progress')
    assert rig.speeds()[-20:].max() < 1e-9
    assert steps.max() < 3.0
    assert override(1.0).successful


datagrams = st.one_of(
    st.binary(max_size=400),
    st.builds(
        lambda cut, edits: ('edit', cut, edits),
        st.integers(0, 400),
        st.lists(st.tuples(st.integers(0, 400), st.integers(0, 255)), max_size=6),
    ),
)


def test_fuzzed_datagrams_never_crash_nor_move(ready, peers):
    operator, peer = ready.operator, ready.peer
    ready.at_rest()
    peer.pause()
    place = list(peer.joints_deg)

    @settings(max_examples=150, deadline=None, suppress_health_check=list(HealthCheck))
    @given(st.lists(datagrams, min_size=1, max_size=4))
    def fuzz(batch):
        for item in batch:
            if isinstance(item, tuple):
                data = bytearray(peer.packet())
                for at, value in item[2]:
                    data[at % len(data)] = value
                item = bytes(data[: len(data) - item[1]])
            peer.socket.sendto(item, peer.bridge)
        time.sleep(0.002)

    fuzz()
    peer.socket.settimeout(0.1)
    answers = []
    try:
        while True:
            answers.append(peer.socket.recv(4096))
    except TimeoutError:
        pass
    # What is still a complete packet may be answered, and then only with a place it was told.
    replies = [peers.EgmSensor.FromString(answer) for answer in answers]
    assert not any(any(reply.speedRef.joints.joints) for reply in replies)
    assert ready.process.process.poll() is None
    # The session starts anew, as a controller's does, and nothing moves.
    time.sleep(TIMEOUT_S + 0.2)
    peer.seqno = peer.reply_seqno = peer.n_sent = 0
    peer.reply_tm = None
    peer.start()
    operator.until_connected()
    ready.at_rest()
    assert peer.joints_deg == place


@pytest.mark.smoke
def test_a_lost_heartbeat_stops_and_latches(rig, message, record_property):
    # That the shipped time-out makes it 0.2 s is asked of the flow, by its own clock.
    operator, peer = rig.running(message).operator, rig.peer
    operator.hold(False)
    released_s = operator.released_s
    operator.until_state(ABORTED)
    assert 'heartbeat' in operator.last.reason
    rig.at_rest()
    moving = [item[0] for item in peer.history if item[2] and any(item[2])]
    record_property('heartbeat_to_standstill_ms', 1e3 * (moving[-1] - released_s))
    assert operator.last.state == ABORTED
    operator.hold()
    rig.at_rest()
    assert operator.last.state == ABORTED
    assert peer.faults == []


@pytest.mark.slow
def test_dry_run_goes_through_everything_and_sends_nothing(
    peers, processes, operator, drivers, start_deg, message, rig
):
    rig.peer.pause()
    rig.process.stop()
    here = Rig(peers, processes, operator, drivers, start_deg, dry_run=True)
    here.peer.expect_reply = False
    here.peer.patience_s = 0.0
    try:
        here.ready()
        operator.offer(message)
        assert operator.arm(message.plan_hash).accepted
        assert operator.start().success
        operator.until_state(RUNNING)
        operator.until(lambda: operator.last.progress > 0.1, 'progress')
        assert operator.last.dry_run
        assert operator.last.n_sent == 0
        assert operator.last.n_received > 50
        assert here.peer.replies == []
    finally:
        here.peer.close()
        here.process.stop()
