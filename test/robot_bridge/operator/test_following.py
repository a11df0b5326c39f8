"""An axis that does not do as it is asked is noticed at once, and none that does is suspected."""

from dataclasses import replace
import threading

import numpy as np
import pytest

from abb_emulator.drives.servo import Servo, ServoSettings
from abb_emulator.egm.guidance_law import GuidanceLaw
from benchmarks.faults.guided_arm import CYCLE_S, GUIDANCE
from robot_bridge.egm.egm_feedback import RobotFeedback
from robot_bridge.egm.egm_messages import MCI_RUNNING
from robot_bridge.egm.session_check import Judgement, Verdict
from robot_bridge.operator import FlowSettings, FlowState, OperatorFlow
from robot_bridge.operator.following_check import FollowingCheck
from robot_bridge.operator.stream_flow import StreamFlow
from robot_bridge.player.plan_path import PlanPath

RATE_HZ = 2.0 / CYCLE_S


class Arm:
    """The law and drives of the emulated controller behind a flow, on a clock of their own."""

    def __init__(
        self, path, servo=None, guidance=GUIDANCE, spoil=lambda arm, joints: joints, stall_cycles=0
    ):
        settings = FlowSettings(dry_run=False, heartbeat_timeout_s=0.0, link_timeout_s=0.25)
        self.flow, self.path, self.spoil = OperatorFlow(settings), path, spoil
        self.law = GuidanceLaw(guidance, path.start_deg, CYCLE_S)
        self.servo = Servo(servo or ServoSettings(), path.start_deg, 1.0 / RATE_HZ)
        self.seqno, self.now, self.past, self.queue = 0, 0.0, [], []
        self.stamp = lambda us: us
        self.run(100).stall(stall_cycles)  # what is queued before the start is queued in it
        self.flow.offer(path)
        self.flow.start(self.now, self.flow.arm(path.plan_hash, 5.0, self.now))

    def cycle(self):
        """Advance the controller, which reads one queued reply, and return what it says."""
        if self.queue:
            reply = self.queue.pop(0)
            self.law.refer(reply.position_deg, reply.speed_deg_s)
        before = self.law.position_deg
        after = self.law.step()
        self.servo.advance(before + np.array([[0.5], [1.0]]) * (after - before))
        joints = tuple(self.servo.measured_deg(0.0).tolist())
        self.past.append(joints)
        self.now += CYCLE_S
        self.seqno += 1
        return RobotFeedback(
            seqno=self.seqno - 1, tm_ms=round(1e3 * self.now),
            joints_deg=tuple(self.spoil(self, joints)), planned_deg=tuple(after.tolist()),
            time_us=self.stamp(round(1e6 * self.now)), motors_on=True, mci_state=MCI_RUNNING,
            rapid_running=True, converged=False,
        )  # fmt: skip

    def answer(self, feedback):
        verdict = Verdict.ACCEPT if feedback.seqno else Verdict.NEW_SESSION
        self.queue.append(self.flow.on_feedback(feedback, Judgement(verdict), self.now))

    def run(self, cycles):
        for _ in range(cycles):
            self.answer(self.cycle())
        return self

    def stall(self, cycles):
        """Let the bridge stand still for some cycles, and then answer all of them at once."""
        for feedback in [self.cycle() for _ in range(cycles)]:
            self.answer(feedback)
        return self


def path_of(plan, model):
    return PlanPath.from_trajectory(plan.plan_hash, plan.trajectory, model.to_controller)


@pytest.fixture(scope='module')
def path(plan, model):
    return path_of(plan, model)


HEALTHY = {
    'as it is': {},
    'slow drives': {'servo': ServoSettings(bandwidth_hz=10.0, dead_time_s=0.06)},
    'ringing drives': {'servo': ServoSettings(damping_ratio=0.3)},
    'friction': {'servo': ServoSettings(friction_deg_s2=100.0)},
    'coarse encoders': {'servo': ServoSettings(encoder_counts=256)},
    'default filter': {'guidance': replace(GUIDANCE, low_pass_hz=20.0)},
    'stiff law': {'guidance': replace(GUIDANCE, gain_1_s=20.0)},
}


@pytest.mark.parametrize('override', [1.0, 0.3, 0.05])
@pytest.mark.parametrize('name', HEALTHY)
def test_an_arm_that_follows_is_never_suspected(path, name, override):
    arm = Arm(path, **HEALTHY[name])
    arm.flow.set_speed_override(override)
    arm.run(round(path.duration_s / CYCLE_S) + 10)
    assert arm.flow.state == FlowState.HOLDING, arm.flow.reason


def test_droop_and_noise_and_a_live_override_are_no_fault(path):
    random = np.random.default_rng(11)
    droop = np.array([0.0, 0.02, -0.02, 0.01, 0.0, 0.01])

    def spoil(arm, joints):
        return np.array(joints) + droop + 2e-4 * random.standard_normal(6)

    arm = Arm(path, spoil=spoil)
    for override in (0.5, 1.0, 0.2, 0.0, 1.0):
        arm.flow.set_speed_override(override)
        arm.run(290)
    arm.run(200)
    assert arm.flow.state == FlowState.HOLDING, arm.flow.reason


@pytest.mark.parametrize('signal', ['random_pulses', 'band_limited_noise'])
@pytest.mark.parametrize('seed', [2, 3])
def test_other_plans_are_followed_too(model, signal, seed):
    from excitation_planner.planner import plan_excitation
    from excitation_planner.request import PlanRequest
    from structural_model.robot_files import load_layout

    start = tuple(model.pose('P3').tolist())
    request = PlanRequest(
        seed=seed, signal=signal, duration_s=8.0, start_position=start, joint_weights=(1.0,),
        require_full_rank=False,
    )  # fmt: skip
    plan = plan_excitation(model, load_layout('irb6660_205_190', 'sensors'), request)
    arm = Arm(path_of(plan, model)).run(2100)
    assert arm.flow.state == FlowState.HOLDING, arm.flow.reason


def frozen(begin, axes):
    def spoil(arm, joints):
        joints = np.array(joints)
        if arm.seqno > begin:
            joints[axes] = np.array(arm.past[begin])[axes]
        return joints

    return spoil


def after(begin, change):
    return lambda arm, joints: change(arm, np.array(joints)) if arm.seqno > begin else joints


def noisy(begin):
    """Frozen, but for noise that looks alive."""
    random = np.random.default_rng(5)
    kept = frozen(begin, slice(None))
    return lambda arm, joints: kept(arm, joints) + 1e-3 * random.standard_normal(6)


def jump(begin, axis, size_deg):
    def change(arm, joints):
        joints[axis] += size_deg
        return joints

    return after(begin, change)


FAULTS = {
    'frozen': lambda begin: frozen(begin, slice(None)),
    'one axis frozen': lambda begin: frozen(begin, [2]),
    'frozen under noise': noisy,
    'an old stretch': lambda begin: after(begin, lambda arm, _: np.array(arm.past[-150])),
    'turned round': lambda begin: after(
        begin, lambda arm, joints: 2.0 * arm.path.start_deg - joints
    ),
    'jump of 0.5 deg': lambda begin: jump(begin, 0, 0.5),
    'jump of 0.1 deg': lambda begin: jump(begin, 3, -0.1),
    'creeps away': lambda begin: after(
        begin, lambda arm, joints: joints + 2e-3 * (arm.seqno - begin)
    ),
    'ten times as far': lambda begin: after(
        begin, lambda arm, joints: arm.path.start_deg + 10.0 * (joints - arm.path.start_deg)
    ),
}


@pytest.mark.parametrize('name', FAULTS)
def test_an_axis_that_does_not_follow_stops_the_motion_within_0_6_s(path, name):
    # Seed 1907: the moment within the motion, after its ramp-in.
    begin = 100 + int(np.random.default_rng(1907).integers(400, 900))
    arm = Arm(path, spoil=FAULTS[name](begin)).run(begin - 100)
    assert arm.flow.state == FlowState.RUNNING, arm.flow.reason
    arm.run(round(0.6 / CYCLE_S))
    assert arm.flow.state == FlowState.ABORTED
    assert 'axis' in arm.flow.reason
    place = arm.law.position_deg
    arm.run(200)
    assert np.abs(arm.law.position_deg - place).max() < 0.05


def test_a_frozen_feedback_is_called_so(path):
    arm = Arm(path, spoil=frozen(720, slice(None))).run(600 + round(0.6 / CYCLE_S))
    assert arm.flow.state == FlowState.ABORTED
    assert 'frozen' in arm.flow.reason or 'correlation' in arm.flow.reason


def test_a_clock_that_ran_and_stands_stops_the_motion(path):
    arm = Arm(path).run(500)
    stopped_us = round(1e6 * arm.now)
    arm.stamp = lambda _: stopped_us
    arm.run(round(0.15 / CYCLE_S))
    assert arm.flow.state == FlowState.ABORTED
    assert 'time' in arm.flow.reason


def test_a_machine_that_is_not_punctual_is_no_fault_of_the_arm(path):
    # Seed 3: every now and then the bridge stands still, and the controller runs on meanwhile.
    random, arm = np.random.default_rng(3), Arm(path, stall_cycles=60)
    while arm.flow.state == FlowState.RUNNING:
        arm.run(int(random.integers(1, 200)))
        arm.stall(int(random.integers(1, 40)))
    assert arm.flow.state == FlowState.HOLDING, arm.flow.reason


def test_a_frozen_feedback_is_noticed_on_such_a_machine_too(path):
    random, arm = np.random.default_rng(4), Arm(path)
    arm.run(300).stall(15).run(50).stall(10).run(200)
    assert arm.flow.state == FlowState.RUNNING, arm.flow.reason
    arm.spoil = frozen(arm.seqno, slice(None))
    for _ in range(20):
        arm.run(10).stall(int(random.integers(1, 5)))
    assert arm.flow.state == FlowState.ABORTED


@pytest.mark.slow
@pytest.mark.parametrize('servo', [{}, {'bandwidth_hz': 10.0, 'dead_time_s': 0.06}])
@pytest.mark.parametrize('seed', [1, 2])
@pytest.mark.parametrize('spoiled', [False, True])
def test_a_program_of_the_controller_is_followed_by_its_own_plan(model, servo, seed, spoiled):
    from excitation_planner.planner import plan_excitation
    from excitation_planner.request import PlanRequest
    from structural_model.robot_files import load_layout

    start = tuple(model.pose('P1').tolist())
    request = PlanRequest(seed=seed, signal='random_pulses', duration_s=12.0, start_position=start)
    path = path_of(
        plan_excitation(model, load_layout('irb6660_205_190', 'sensors'), request), model
    )
    drives = Servo(ServoSettings(**servo), path.start_deg, 1.0 / RATE_HZ)
    still = RobotFeedback(
        seqno=0, tm_ms=0, joints_deg=tuple(path.start_deg), planned_deg=tuple(path.start_deg),
        time_us=0, motors_on=True, mci_state=MCI_RUNNING, rapid_running=True, converged=False,
    )  # fmt: skip
    check = FollowingCheck(path, path.start_deg, still, CYCLE_S, 2.0)
    n_cycles, faults, before = round(path.duration_s / CYCLE_S), [], path.start_deg
    for number in range(1, n_cycles):
        planned = path.position(number * CYCLE_S)
        drives.advance(before + np.array([[0.5], [1.0]]) * (planned - before))
        before = planned
        joints = still.joints_deg
        if not (spoiled and number > n_cycles // 2):
            joints = tuple(drives.measured_deg(0.0).tolist())
        still = replace(still, joints_deg=joints, time_us=4032 * number)
        faults.append(check.fault(planned, still, 1))
    found = [number for number, fault in enumerate(faults) if fault]
    if not spoiled:
        assert not found, faults[found[0]]
    else:
        assert n_cycles // 2 <= found[0] < n_cycles // 2 + 1.5 / CYCLE_S


def test_a_packet_that_skips_a_thousand_million_numbers_holds_nobody_up(path):
    """What has begun with it ends at once: aborts wait for the same lock."""
    start = tuple(path.start_deg.tolist())
    told = RobotFeedback(
        seqno=0, tm_ms=0, joints_deg=start, planned_deg=start, time_us=0, motors_on=True,
        mci_state=MCI_RUNNING, rapid_running=True, converged=False,
    )  # fmt: skip
    flow = StreamFlow(FlowSettings(dry_run=False, heartbeat_timeout_s=0.0))
    flow.offer(path)
    flow.start(0.0, flow.arm(path.plan_hash, 5.0, 0.0))
    flow.on_feedback(told, Judgement(Verdict.NEW_SESSION), 0.001)
    later = replace(told, seqno=2**30, tm_ms=4, time_us=4000)
    asked = threading.Thread(
        target=flow.on_feedback,
        args=(later, Judgement(Verdict.ACCEPT, n_steps=2**30), 0.005),
        daemon=True,
    )
    asked.start()
    asked.join(10.0)
    assert not asked.is_alive()
    flow.abort('by the operator')
    assert flow.state == FlowState.ABORTED
