"""A program of the controller is stopped by every abort; where it cannot be, a person is told."""

from dataclasses import replace
import threading
import time

import numpy as np
import pytest

from excitation_planner.planner import plan_excitation
from excitation_planner.request import PlanRequest
from excitation_planner.signals import RANDOM_PULSES
from modal_core.errors import BridgeError
from robot_bridge.backends.backends import BackendSettings, make_backend
from robot_bridge.egm.egm_feedback import RobotFeedback
from robot_bridge.egm.egm_messages import MCI_STOPPED
from robot_bridge.egm.session_check import Judgement, Verdict
from robot_bridge.operator import FlowSettings, FlowState
from robot_bridge.player.plan_path import PlanPath
from structural_model.robot_files import load_layout

CYCLE_S = 0.004032


@pytest.fixture(scope='module')
def plan(model):
    """Return a short plan of moves; seed 1."""
    request = PlanRequest(
        seed=1,
        signal=RANDOM_PULSES,
        duration_s=3.0,
        start_position=tuple(model.pose('P1').tolist()),
    )
    return plan_excitation(model, load_layout('irb6660_205_190', 'sensors'), request)


class Rig:
    """A backend, the stream of the program it waits for, and a clock that only the rig moves."""

    def __init__(self, model, plan, folder, address=''):
        settings = BackendSettings(
            name='abb_rapid',
            rapid_file=folder / 'plan.mod',
            rws_address=address,
            flow=FlowSettings(dry_run=False, cycle_s=CYCLE_S),
        )
        self.backend = make_backend(settings, model)
        self.flow, self.now, self.plan = self.backend.flow, 100.0, plan
        path = PlanPath.from_trajectory(plan.plan_hash, plan.trajectory, model.to_controller)
        start = tuple(path.start_deg.tolist())
        self.feedback = RobotFeedback(
            seqno=0, tm_ms=0, joints_deg=start, planned_deg=start, time_us=0, motors_on=True,
            mci_state=MCI_STOPPED, rapid_running=True, converged=False,
        )  # fmt: skip
        self.token = ''
        self.backend.take(plan, path)

    def armed(self):
        self.token = self.flow.arm(self.plan.plan_hash, 30.0, self.now)
        self.flow.heartbeat(self.now, self.token)
        return self

    def waiting(self):
        self.armed().backend.start(self.now, self.token)
        return self

    def running(self):
        return self.waiting().stream(50)

    def stream(self, cycles=1, verdict=Verdict.ACCEPT, **changes):
        for _ in range(cycles):
            self.now += CYCLE_S
            self.flow.heartbeat(self.now, self.token)
            packet = replace(self.feedback, **changes)
            self.backend.answer(packet, Judgement(verdict, 'session_restarted'), self.now)
        return self

    def wait(self, time_s, holding=True):
        self.now += time_s
        if holding:
            self.flow.heartbeat(self.now, self.token)
        self.flow.poll(self.now)
        return self


@pytest.fixture
def rig(model, plan, tmp_path):
    return Rig(model, plan, tmp_path)


ABORTS = {
    'operator, waiting': lambda rig: rig.waiting().backend.abort('aborted by the operator'),
    'operator, running': lambda rig: rig.running().backend.abort('aborted by the operator'),
    'operator, a program of somebody else': lambda rig: rig.stream(3).backend.abort('by hand'),
    'second sender': lambda rig: rig.running().backend.abort('second_sender 127.0.0.2:1'),
    'heartbeat': lambda rig: rig.running().wait(0.2, holding=False),
    'heartbeat, waiting': lambda rig: rig.waiting().wait(0.2, holding=False),
    'link': lambda rig: rig.running().wait(0.1),
    'session': lambda rig: rig.running().stream(verdict=Verdict.NEW_SESSION),
    'motors': lambda rig: rig.running().stream(motors_on=False),
    'program ended early': lambda rig: rig.running().stream(rapid_running=False),
    'never started': lambda rig: rig.waiting().wait(121.0),
    'away from the start': lambda rig: rig.waiting().stream(joints_deg=(0.0,) * 6),
    'deactivated': lambda rig: rig.running().flow.deactivate(),
}


@pytest.mark.parametrize('path', ABORTS)
def test_without_web_services_every_abort_sends_to_the_pendant(rig, path):
    ABORTS[path](rig)
    assert rig.flow.state == FlowState.ABORTED
    assert rig.flow.reason.count('use the pendant') == 1, rig.flow.reason


def test_a_program_that_ends_in_time_needs_nobody(rig):
    rig.running().stream(round(0.95 * rig.plan.duration_s / CYCLE_S))
    rig.stream(rapid_running=False)
    assert rig.flow.state == FlowState.HOLDING
    assert 'pendant' not in rig.flow.reason


@pytest.mark.parametrize('how', ['the stream falls silent', 'the program stops'])
def test_a_stream_that_ends_before_the_arm_is_at_the_end_of_the_plan_stops_the_program(
    model, plan, tmp_path, web, how
):
    """In the last tenth of a plan of minutes an arm moves for long, with nobody who holds."""
    controller = web()
    rig = Rig(model, plan, tmp_path, controller.address).running()
    rig.stream(round(0.95 * plan.duration_s / CYCLE_S))
    away = tuple(angle + 0.02 for angle in rig.feedback.joints_deg)
    rig.stream(rapid_running='silent' in how, joints_deg=away, planned_deg=away)
    rig.wait(0.1)
    assert rig.flow.state == FlowState.ABORTED
    until(lambda: controller.posts()[-1:] == ['stop'])


def test_an_approach_is_released_and_followed_like_any_plan(model, tmp_path):
    here = model.to_serial(np.radians([8.0, 45, -10, 90, -90, 20.0]))
    approach = plan_excitation(model, None, PlanRequest(
        signal='approach', approach_from=tuple(here.tolist()),
        start_position=tuple(model.pose('P1').tolist()),
    ))  # fmt: skip
    rig = Rig(model, approach, tmp_path).running()
    end = tuple(np.degrees(model.to_controller(model.pose('P1'))).tolist())
    rig.stream(round(0.95 * approach.duration_s / CYCLE_S))
    rig.stream(rapid_running=False, joints_deg=end, planned_deg=end)
    assert rig.flow.state == FlowState.HOLDING
    assert 'Slow approach' in (tmp_path / 'plan.mod').read_text()


def until(condition):
    deadline = time.monotonic() + 60.0
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.005)


@pytest.mark.parametrize('path', ABORTS)
def test_with_web_services_every_abort_stops_the_program(model, plan, tmp_path, web, path):
    controller = web()
    rig = Rig(model, plan, tmp_path, controller.address)
    ABORTS[path](rig)
    assert rig.flow.state == FlowState.ABORTED
    until(lambda: controller.posts()[-1:] == ['stop'])
    assert 'pendant' not in rig.flow.reason


def test_a_stop_that_fails_sends_to_the_pendant_and_may_be_asked_for_again(
    model, plan, tmp_path, web
):
    controller = web()
    rig = Rig(model, plan, tmp_path, controller.address).running()
    controller.answers['/rw/rapid/execution'] = (503, {})
    rig.backend.abort('aborted by the operator')
    until(lambda: 'NOT STOPPED, use the pendant' in rig.flow.reason)
    controller.answers.clear()
    n_stops = controller.posts().count('stop')
    rig.stream(1)  # it still runs
    until(lambda: not rig.flow.stopping)
    rig.backend.abort('aborted by the operator')
    until(lambda: controller.posts().count('stop') > n_stops)


def test_a_bridge_that_ends_waits_for_the_answer_to_its_stop(model, plan, tmp_path, web):
    controller = web(hold='action=stop')
    rig = Rig(model, plan, tmp_path, controller.address).running()
    rig.flow.deactivate()
    assert controller.waiting.wait(60.0)
    settled = threading.Thread(target=rig.flow.settle)
    settled.start()
    settled.join(0.05)
    assert settled.is_alive()
    controller.release.set()
    settled.join(60.0)
    assert not rig.flow.stopping


AWAY = {f'rax_{n}': str(v) for n, v in enumerate((80, 45, -10, 90, -90, 0), 1)}
UNREADY = {
    'elsewhere': ('/rw/motionsystem/mechunits/ROB_1/jointtarget', AWAY),
    'another program runs': ('/rw/rapid/execution', {'ctrlexecstate': 'running'}),
    'two arms': ('/rw/rapid/tasks', [
        {'name': f'T_ROB{n}', 'type': 'norm', 'active': 'On', 'motiontask': 'TRUE'} for n in (1, 2)
    ]),
}  # fmt: skip


@pytest.mark.parametrize('case', UNREADY)
def test_a_start_that_is_refused_touches_nothing_and_keeps_the_release(
    model, plan, tmp_path, web, case
):
    controller = web(states=dict([UNREADY[case]]))
    rig = Rig(model, plan, tmp_path, controller.address).armed()
    with pytest.raises(BridgeError):
        rig.backend.start(rig.now, rig.token)
    assert rig.flow.state == FlowState.ARMED
    assert controller.posts() == []


@pytest.mark.parametrize(
    'hold', ['loadmod', 'resetpp', 'module-text', '/pcp', 'jointtarget', 'action=start']
)
def test_an_abort_while_it_is_being_started_leaves_it_stopped(model, plan, tmp_path, web, hold):
    controller = web(hold=hold)
    rig = Rig(model, plan, tmp_path, controller.address).armed()
    refused = []

    def start():
        try:
            rig.backend.start(rig.now, rig.token)
        except BridgeError as error:
            refused.append(str(error))

    starting = threading.Thread(target=start)
    starting.start()
    until(controller.waiting.is_set)
    rig.backend.abort('aborted by the operator')
    if hold == 'action=start':
        # Whenever the controller acts on it: a stop follows at once, not after its answer.
        until(lambda: controller.posts().count('stop') >= 3)
    controller.release.set()
    starting.join()
    assert 'aborted by the operator' in refused[0]
    posts = controller.posts()
    if hold == 'action=start':
        assert posts[-1] == 'stop' and rig.flow.state == FlowState.ABORTED
    else:
        assert 'start' not in posts
    assert rig.flow.state == FlowState.ABORTED


def test_a_faster_point_than_manual_mode_allows_needs_automatic_mode(model, web):
    settings = BackendSettings(
        name='abb_egm',
        guidance_enabled=True,
        controller_address='192.168.125.1',
        point_speed_m_s=0.5,
        flow=FlowSettings(dry_run=False),
    )
    with pytest.raises(BridgeError, match='operating mode'):
        make_backend(settings, model)
    manual = web(states={'/rw/panel/opmode': {'opmode': 'MANR'}})
    backend = make_backend(replace(settings, rws_address=manual.address), model)
    with pytest.raises(BridgeError, match='MANR'):
        backend.start(time.monotonic(), '')
    automatic = make_backend(replace(settings, rws_address=web().address), model)
    with pytest.raises(BridgeError, match='not armed'):  # asked, answered, and refused for this
        automatic.start(time.monotonic(), '')
    slow = make_backend(replace(settings, point_speed_m_s=0.25), model)
    with pytest.raises(BridgeError, match='not armed'):
        slow.start(time.monotonic(), '')
