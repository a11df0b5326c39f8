"""Nothing moves by accident, and whatever fails ends in standstill."""

from dataclasses import replace

import numpy as np
import pytest

from modal_core.errors import BridgeError, PlanError
from robot_bridge.backends.guidance_backend import GuidanceBackend
from robot_bridge.egm.egm_feedback import RobotFeedback
from robot_bridge.egm.egm_messages import MCI_RUNNING, MCI_STOPPED
from robot_bridge.egm.session_check import Judgement, Verdict
from robot_bridge.operator import AWAY, FlowSettings, FlowState, OperatorFlow
from robot_bridge.player.plan_path import PlanPath
from robot_bridge.player.plan_player import PlanPlayer, PlayerSettings

CYCLE_S = 0.004032
READY = RobotFeedback(
    seqno=0, tm_ms=0, joints_deg=(10.0,) * 6, planned_deg=(10.0,) * 6, time_us=0,
    motors_on=True, mci_state=MCI_RUNNING, rapid_running=True, converged=False,
)  # fmt: skip


def sweep(duration_s=4.0, amplitude_deg=0.5, hz=5.0):
    """A sine about 10 deg as cubic pieces."""
    from excitation_planner.motion.trajectory import Trajectory

    time = np.arange(0.0, duration_s, 0.004)
    envelope = np.sin(np.pi * time / time[-1]) ** 2
    speed = np.radians(amplitude_deg) * 2 * np.pi * hz * envelope * np.cos(2 * np.pi * hz * time)
    speed[0] = speed[-1] = 0.0
    trajectory = Trajectory.from_velocity(
        np.full(6, np.radians(10.0)), np.tile(speed[:, None], 6), 0.004
    )
    return PlanPath.from_trajectory('abc123', trajectory, lambda q: q)


class Rig:
    """A flow and a controller that follows perfectly."""

    def __init__(self, **changes):
        settings = FlowSettings(**{'dry_run': False, **changes})
        self.flow = OperatorFlow(settings)
        self.now = 100.0
        self.feedback = READY
        self.positions = []
        self.beating, self.token = True, ''

    def run(self, cycles, **changes):
        for _ in range(cycles):
            self.now += CYCLE_S
            if self.beating:
                self.flow.heartbeat(self.now, self.token)
            new = self.feedback.seqno == 0
            judgement = Judgement(Verdict.NEW_SESSION if new else Verdict.ACCEPT)
            feedback = replace(self.feedback, **changes)
            reference = self.flow.on_feedback(feedback, judgement, self.now)
            position = self.feedback.planned_deg
            if reference is not None and feedback.mci_state == MCI_RUNNING:
                position = tuple(reference.position_deg + CYCLE_S * reference.speed_deg_s)
            self.positions.append(position)
            self.feedback = replace(
                self.feedback,
                seqno=self.feedback.seqno + 1,
                joints_deg=position,
                planned_deg=position,
            )
        return self

    def go(self):
        self.flow.offer(sweep())
        return self.arm().start()

    def arm(self, timeout_s=5.0):
        self.token = self.flow.arm('abc123', timeout_s, self.now)
        return self

    def start(self):
        if self.beating:
            self.flow.heartbeat(self.now, self.token)
        self.flow.start(self.now, self.token)
        return self

    @property
    def speed(self):
        return np.abs(np.diff(np.array(self.positions), axis=0)).max(axis=1) / CYCLE_S


def test_a_started_plan_is_played_to_its_end_and_back():
    rig = Rig().run(3).go().run(1100)
    assert rig.flow.state == FlowState.HOLDING
    path = sweep()
    np.testing.assert_allclose(rig.positions[-1], path.position(10.0), atol=1e-9)
    times = np.arange(len(rig.positions)) * CYCLE_S
    # After the ramp-in the positions are those of the plan, one cycle ahead.
    index = 500
    np.testing.assert_allclose(
        rig.positions[index], path.position(times[index] - 2 * CYCLE_S), atol=2e-3
    )


def test_ramp_in_has_no_step_in_speed():
    rig = Rig().run(3).go().run(300)
    assert np.abs(np.diff(rig.speed)).max() < 2.5


@pytest.mark.parametrize(
    ('prepare', 'part'),
    [
        (lambda rig: None, 'no plan'),
        (lambda rig: rig.flow.offer(replace(sweep(), plan_hash='other')), 'hash'),
    ],
)
def test_arm_is_bound_to_the_plan(prepare, part):
    rig = Rig().run(3)
    prepare(rig)
    with pytest.raises(BridgeError, match=part):
        rig.arm()


def test_a_release_outlasts_a_repeated_delivery_of_its_plan_but_no_other_plan():
    rig = Rig().run(3)
    rig.flow.offer(sweep())
    rig.arm()
    rig.flow.offer(sweep())
    assert rig.flow.state == FlowState.ARMED
    rig.flow.offer(replace(sweep(), plan_hash='other'))
    assert rig.flow.state == FlowState.IDLE
    with pytest.raises(BridgeError, match='not armed'):
        rig.start()


def played(rig):
    rig.go().run(3000)


@pytest.mark.parametrize(
    ('bring', 'state'),
    [
        (lambda rig: rig.flow.offer(sweep()), FlowState.IDLE),
        (lambda rig: (rig.flow.offer(sweep()), rig.arm()), FlowState.ARMED),
        (played, FlowState.HOLDING),
        (lambda rig: (rig.go().run(30), rig.flow.abort('stop'), rig.run(60)), FlowState.ABORTED),
    ],
)
def test_the_same_plan_again_changes_nothing_and_starts_nothing(bring, state):
    rig = Rig().run(3)
    bring(rig)
    rig.run(3)
    assert rig.flow.state == state
    before, progress = rig.flow.reason, rig.flow.progress
    stood = len(rig.positions)
    for _ in range(3):
        rig.flow.offer(sweep())
        rig.run(20)
    assert (rig.flow.state, rig.flow.reason, rig.flow.progress) == (state, before, progress)
    assert np.ptp(rig.positions[stood:], axis=0).max() == 0.0
    if state == FlowState.ARMED:
        rig.start().run(3)  # with the token of the one release
        assert rig.flow.state == FlowState.RUNNING
    else:
        with pytest.raises(BridgeError, match='not armed'):
            rig.flow.start(rig.now, rig.token)


@pytest.mark.parametrize('timeout_s', [0.0, -1.0, 301.0, float('nan'), float('inf')])
def test_arm_needs_a_bounded_time_out(timeout_s):
    rig = Rig().run(3)
    rig.flow.offer(sweep())
    with pytest.raises(BridgeError, match='timeout_s'):
        rig.arm(timeout_s)


def test_start_without_arm_and_after_the_time_out_is_refused():
    rig = Rig().run(3)
    rig.flow.offer(sweep())
    with pytest.raises(BridgeError, match='not armed'):
        rig.start()
    rig.arm(0.1)
    rig.run(40)
    with pytest.raises(BridgeError, match='not armed'):
        rig.start()


@pytest.mark.parametrize(
    ('changes', 'part'),
    [
        ({'motors_on': False}, 'motors'),
        ({'mci_state': MCI_STOPPED}, 'session is stopped'),
        ({'rapid_running': False}, 'RAPID'),
        ({'joints_deg': (10.0, 11.0, 10.0, 10.0, 10.0, 10.0)}, 'axis 2'),
    ],
)
def test_start_is_refused_when_the_controller_is_not_ready(changes, part):
    rig = Rig().run(3)
    rig.flow.offer(sweep())
    rig.arm()
    rig.run(1, **changes)
    rig.feedback = replace(rig.feedback, **changes)
    with pytest.raises(BridgeError, match=part):
        rig.start()


def test_start_needs_the_heartbeat():
    rig = Rig()
    rig.beating = False
    rig.run(3)
    rig.flow.offer(sweep())
    rig.arm()
    with pytest.raises(BridgeError, match='heartbeat'):
        rig.start()


def test_dry_run_sends_nothing():
    rig = Rig(dry_run=True).run(3).go()
    rig.now += CYCLE_S
    rig.flow.heartbeat(rig.now, rig.token)
    reply = rig.flow.on_feedback(replace(rig.feedback), Judgement(Verdict.ACCEPT), rig.now)
    assert reply is None
    assert rig.flow.state == FlowState.RUNNING
    assert rig.flow.progress > 0.0


def stopped(rig, cycles=40):
    """Assert that the arm comes to rest within the ramp and stays; return where."""
    ramp = int(np.ceil(rig.flow.settings.player.stop_ramp_s / CYCLE_S)) + 2
    rig.run(cycles)
    assert rig.speed[-cycles + ramp :].max() == 0.0
    assert rig.flow.state == FlowState.ABORTED
    return rig.positions[-1]


@pytest.mark.parametrize('when', [260, 333, 431, 600])
def test_abort_ramps_to_hold_and_latches(when):
    rig = Rig().run(3).go().run(when)
    rig.flow.abort('test')
    place = stopped(rig)
    assert np.abs(np.array(place) - rig.positions[when]).max() < 16.0 * 0.06
    rig.run(200)
    assert rig.positions[-1] == place
    with pytest.raises(BridgeError):
        rig.start()
    with pytest.raises(BridgeError, match='ABORTED'):
        rig.arm()
    rig.flow.reset()
    assert rig.flow.state == FlowState.IDLE


def test_a_lost_heartbeat_stops_within_200_ms():
    rig = Rig().run(3).go().run(400)
    rig.beating = False
    rig.run(60)
    assert rig.flow.state == FlowState.ABORTED
    assert rig.speed[403 + int(0.2 / CYCLE_S) + 1 :].max() == 0.0


@pytest.mark.parametrize(
    'changes',
    [{'motors_on': False, 'mci_state': MCI_STOPPED}, {'rapid_running': False}],
)
def test_a_controller_that_stops_is_never_resumed(changes):
    rig = Rig().run(3).go().run(400)
    rig.run(5, **changes)
    assert rig.flow.state == FlowState.ABORTED
    stopped(rig)


def test_a_silent_link_latches_and_the_next_reply_holds_where_the_arm_is():
    rig = Rig().run(3).go().run(400)
    rig.now += 0.05
    rig.flow.poll(rig.now)
    assert rig.flow.state == FlowState.ABORTED
    drifted = tuple(np.array(rig.feedback.planned_deg) + 0.3)
    rig.feedback = replace(rig.feedback, planned_deg=drifted, joints_deg=drifted)
    rig.run(50)
    np.testing.assert_allclose(rig.positions[-1], drifted, atol=1e-12)
    assert rig.flow.state == FlowState.ABORTED


def test_a_restarted_session_latches():
    rig = Rig().run(3).go().run(400)
    rig.feedback = replace(rig.feedback, seqno=0)
    rig.run(2)
    assert rig.flow.state == FlowState.ABORTED


def test_an_arm_that_does_not_follow_stops():
    rig = Rig().run(3).go().run(400)
    rig.run(1, joints_deg=(10.0, 10.0, 13.0, 10.0, 10.0, 10.0))
    assert rig.flow.state == FlowState.ABORTED
    assert 'axis 3' in rig.flow.reason


def test_half_override_halves_the_amplitude():
    full = np.ptp(np.array(Rig().run(3).go().run(1100).positions), axis=0)
    rig = Rig().run(3)
    rig.flow.set_speed_override(0.5)
    rig.go()
    half = np.ptp(np.array(rig.run(1100).positions), axis=0)
    np.testing.assert_allclose(half, 0.5 * full, rtol=0.02)


@pytest.mark.parametrize('fraction', [-0.1, 1.1, float('nan')])
def test_override_outside_its_range_is_refused(fraction):
    with pytest.raises(BridgeError):
        Rig().flow.set_speed_override(fraction)


@pytest.mark.parametrize('period_s', [0.024, 0.002, 0.0048, 0.0042, 0.0039])
def test_start_is_refused_when_the_controller_has_another_period(period_s):
    rig = Rig()
    for n_cycles in range(120):
        rig.run(1, tm_ms=round(1e3 * period_s * n_cycles))
    with pytest.raises(BridgeError, match='another period'):
        rig.go()
    rig.run(100)
    assert not rig.speed.any()


@pytest.mark.parametrize('period_s', [0.004, 0.004032, 0.0])
def test_start_is_granted_at_the_period_expected_and_with_a_clock_that_stands(period_s):
    rig = Rig()
    for n_cycles in range(120):
        rig.run(1, tm_ms=(2**32 - 100 + round(1e3 * period_s * n_cycles)) % 2**32)
    rig.go()
    assert rig.flow.state == FlowState.RUNNING


def slow_sweep(reach_deg, speed_deg_s, n_times=1):
    """Away and back, at one speed for most of the time."""
    from excitation_planner.motion.trajectory import Trajectory

    duration_s = 2.0 * n_times * reach_deg / speed_deg_s
    time = np.linspace(0.0, duration_s, round(duration_s / 0.004))
    speed = np.radians(speed_deg_s) * np.tanh(
        20.0 * np.sin(2.0 * np.pi * n_times * time / duration_s)
    )
    speed[0] = speed[-1] = 0.0
    trajectory = Trajectory.from_velocity(
        np.full(6, np.radians(10.0)), np.tile(speed[:, None], 6), time[1]
    )
    return PlanPath.from_trajectory('abc123', trajectory, lambda q: q)


def test_no_ramp_of_the_amplitude_makes_a_path_faster_than_a_twentieth_more():
    path, speeds = slow_sweep(3.0, 6.0, n_times=30), []
    player = PlanPlayer(path, path.start_deg, PlayerSettings(ramp_in_s=0.01))
    while not player.at_rest:
        player.override_target = 0.3 if 0.5 < player.progress < 0.7 else 1.0
        speeds.append(np.abs(player.step(CYCLE_S).speed_deg_s).max())
    assert 0.99 * 6.0 < max(speeds) < 1.06 * 6.0
    assert min(speeds[len(speeds) * 6 // 10 : len(speeds) * 7 // 10]) < 0.5 * 6.0


def test_a_path_that_goes_far_begins_slowly_and_keeps_its_speed_and_its_end():
    path, positions = slow_sweep(40.0, 10.0), []
    player = PlanPlayer(path, path.start_deg + 0.1, PlayerSettings(ramp_in_s=0.01))
    while not player.at_rest:
        positions.append(player.step(CYCLE_S).position_deg)
    speed = np.diff(positions, axis=0) / CYCLE_S
    own = np.abs(path.coefficients[-2])
    own_acceleration = np.abs(2.0 * path.coefficients[-3]).max()
    assert np.abs(speed).max() < 1.06 * own.max()
    assert np.abs(np.diff(speed, axis=0)).max() / CYCLE_S < 1.2 * own_acceleration
    assert player.position_deg == pytest.approx(path.position(path.duration_s), abs=1e-6)


def test_a_path_too_fast_for_the_lag_of_a_controller_is_not_taken_for_guidance():
    backend = GuidanceBackend('emulator', OperatorFlow(FlowSettings()))
    with pytest.raises(PlanError, match=r'too fast.*<= 100.0 deg/s.*speed_high'):
        backend.take(None, slow_sweep(40.0, 110.0))
    assert backend.flow.path is None


def test_an_arm_away_from_the_start_is_told_before_a_release():
    rig = Rig().run(3)
    rig.flow.offer(sweep())
    assert rig.flow.away == ''
    rig.run(1, joints_deg=(10.0, 10.0, 10.3, 10.0, 10.0, 10.0))
    assert rig.flow.away == f'{AWAY}: axis 3 by 0.30 deg, 0.2 allowed'


def test_the_beats_of_a_second_operator_stop_the_motion():
    rig = Rig().run(3).go()
    rig.beating = False
    for n_beats in range(1, 40):
        rig.flow.heartbeat(rig.now, rig.token, 1000 + n_beats)
        rig.run(10)
    assert rig.flow.state == FlowState.RUNNING
    rig.flow.heartbeat(rig.now, rig.token, 1)
    assert rig.flow.state == FlowState.ABORTED
    assert 'second operator' in rig.flow.reason


def test_an_operator_who_comes_back_after_a_while_is_no_second_one():
    rig = Rig().run(3)
    rig.flow.offer(sweep())
    rig.arm().flow.heartbeat(rig.now, rig.token, 1000)
    rig.beating = False
    rig.run(100)
    rig.flow.heartbeat(rig.now, rig.token, 1)
    rig.start()
    assert rig.flow.state == FlowState.RUNNING


def test_requests_that_reach_two_bridges_move_one():
    rigs = [Rig().run(3), Rig().run(3)]
    for rig in rigs:
        rig.flow.offer(sweep())
        rig.arm()
    meant = rigs[0]
    # What one operator says is heard by both, before either knows of the other.
    for rig in rigs:
        rig.token = meant.token
    meant.start()
    with pytest.raises(BridgeError, match='token'):
        rigs[1].start()
    for rig in rigs:
        rig.run(300)
    assert meant.flow.state == FlowState.RUNNING and meant.speed.max() > 0.0
    assert rigs[1].flow.state == FlowState.ARMED and rigs[1].speed.max() == 0.0
    assert rigs[1].flow.release.n_foreign >= 300
    # Each is told of the other: the one that moves stops, none can be released.
    for rig in rigs:
        rig.flow.meet('another node offers ~/arm')
    stopped(meant)
    for rig in rigs:
        assert rig.flow.state == FlowState.ABORTED
        with pytest.raises(BridgeError, match='name clash'):
            rig.flow.reset()
    meant.flow.meet('')
    meant.flow.reset()
    with pytest.raises(BridgeError, match='not armed'):
        meant.start()  # the token has ended with the release


def test_the_beats_of_an_earlier_release_do_not_count_for_the_next():
    rig = Rig().run(3)
    rig.flow.offer(sweep())
    old = rig.arm().token
    rig.arm()
    rig.beating = False
    rig.flow.heartbeat(rig.now, old)
    with pytest.raises(BridgeError, match='heartbeat'):
        rig.start()


@pytest.mark.parametrize('timeout_s', [61.0, 300.0])
def test_no_release_is_longer_than_the_exported_session(timeout_s):
    rig = Rig().run(3)
    backend = GuidanceBackend('emulator', rig.flow)
    path = sweep(duration_s=30.0)
    backend.take(replace_plan(path), path)
    with pytest.raises(BridgeError, match='timeout_s'):
        rig.arm(timeout_s)
    rig.arm(60.0)
    assert rig.flow.state == FlowState.ARMED


def replace_plan(path):
    """Stand in for a plan where only its hash is told."""
    from types import SimpleNamespace

    return SimpleNamespace(plan_hash=path.plan_hash)


def test_a_release_ends_with_the_session_it_was_given_in():
    rig = Rig().run(3)
    rig.flow.offer(sweep())
    rig.arm()
    rig.run(2, mci_state=MCI_STOPPED, rapid_running=False)
    assert rig.flow.state == FlowState.IDLE
    rig.run(5)  # the program is started again
    with pytest.raises(BridgeError, match='not armed'):
        rig.start()


@pytest.mark.parametrize('begins', [True, False])
@pytest.mark.parametrize('mci', [MCI_RUNNING, MCI_STOPPED])
def test_a_place_the_arm_does_not_stand_at_is_never_asked_for(begins, mci):
    """One packet claims that the controller holds 90,000 deg; nothing is released."""
    rig = Rig().run(0 if begins else 5)
    away = replace(READY, seqno=rig.feedback.seqno, planned_deg=(9e4,) * 6, mci_state=mci)
    verdict = Verdict.NEW_SESSION if begins else Verdict.ACCEPT
    assert rig.flow.on_feedback(away, Judgement(verdict), rig.now + CYCLE_S) is None
    rig.feedback = replace(READY, seqno=away.seqno + 1)
    rig.now += CYCLE_S
    rig.run(50)
    assert set(rig.positions) == {(10.0,) * 6}


@pytest.mark.parametrize('part', [('planned_deg',), ('planned_deg', 'joints_deg')])
@pytest.mark.parametrize('released', [False, True])
def test_a_controller_that_is_always_elsewhere_is_not_chased(part, released):
    """It says 5 deg more than what it was asked for: asked for that, it would say 10."""
    rig = Rig().run(5)
    if released:
        rig.go().run(300)
    asked = np.array(rig.positions[-1])
    references = []
    for _ in range(500):
        rig.now += CYCLE_S
        away = dict.fromkeys(part, tuple((asked + 5.0).tolist()))
        said = replace(rig.feedback, seqno=rig.feedback.seqno + 1, **away)
        rig.feedback = said
        reference = rig.flow.on_feedback(said, Judgement(Verdict.ACCEPT), rig.now)
        if reference is not None:
            assert not np.any(reference.speed_deg_s)
            asked = np.array(reference.position_deg)
            rig.feedback = replace(said, joints_deg=tuple(asked.tolist()))
            references.append(asked)
    # In motion, where the arm stands too, it is asked once to stay there: its last reference has
    # a speed, which would go on.  At rest no answer leaves it where it is.
    assert (len(references) > 0) == (released and len(part) == 2)
    for position in references:
        np.testing.assert_allclose(position, np.array(rig.positions[-1]) + 5.0)
    assert rig.flow.state == FlowState.ABORTED
    with pytest.raises(BridgeError):
        rig.flow.start(rig.now, rig.token)


@pytest.mark.parametrize('gain', [5.0, 20.0])
@pytest.mark.parametrize('offset_deg', [2.5, 5.0, 20.0])
@pytest.mark.parametrize('comm_timeout_s', [0.1, 1.0])
def test_an_arm_at_rest_whose_angles_are_told_anew_is_moved_nowhere(
    gain, offset_deg, comm_timeout_s
):
    """EGM's law, speed = gain times (reference - place), in angles of the arm's own."""
    rig, arm, reference, silent_s = Rig().run(5), 10.0, 10.0, 0.0
    while silent_s <= comm_timeout_s:
        rig.now += CYCLE_S
        told = (arm + offset_deg,) * 6
        rig.feedback = replace(
            rig.feedback, seqno=rig.feedback.seqno + 1, planned_deg=told, joints_deg=told
        )
        answer = rig.flow.on_feedback(rig.feedback, Judgement(Verdict.ACCEPT), rig.now)
        silent_s += CYCLE_S
        if answer is not None:
            reference, silent_s = float(answer.position_deg[0]), 0.0
        arm += CYCLE_S * gain * (reference - arm)
    assert arm == 10.0, 'nobody released anything'
    assert rig.flow.state == FlowState.ABORTED


def test_what_is_held_is_where_guidance_began_not_where_one_packet_said_before():
    rig = Rig().run(5)
    rig.now += CYCLE_S
    said = replace(rig.feedback, planned_deg=(11.9,) + (10.0,) * 5, mci_state=MCI_STOPPED)
    rig.flow.on_feedback(said, Judgement(Verdict.ACCEPT), rig.now)
    rig.run(50)
    assert set(rig.positions) == {(10.0,) * 6}


@pytest.mark.parametrize('fraction', [0.0, 0.1, 0.5])
def test_a_speed_override_set_before_the_start_holds_from_the_start(fraction):
    """A plan that begins at once: 0.5 deg at 5 Hz from its first second on."""
    rig, path = Rig().run(3), sweep(duration_s=2.0)
    rig.flow.set_speed_override(fraction)
    rig.flow.offer(path)
    rig.arm().start().run(600)
    assert rig.flow.state == FlowState.HOLDING
    reach = np.abs(np.array(rig.positions) - 10.0).max()
    asked = np.abs(path.coefficients[-1] - 10.0).max()
    assert reach <= fraction * asked + 1e-9
