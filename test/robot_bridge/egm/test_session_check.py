"""Who is believed: sender, sequence, time, jumps."""

from dataclasses import replace

import pytest

from robot_bridge.egm.egm_feedback import RobotFeedback
from robot_bridge.egm.session_check import SessionCheck, SessionLimits, Verdict

HOME = ('127.0.0.1', 40000)
FIRST = RobotFeedback(
    seqno=10, tm_ms=1000, joints_deg=(0.0,) * 6, planned_deg=(0.0,) * 6, time_us=0,
    motors_on=True, mci_state=3, rapid_running=True, converged=False,
)  # fmt: skip


@pytest.fixture
def check():
    check = SessionCheck(SessionLimits(controller_address='127.0.0.1'))
    assert check.feedback(FIRST, HOME, 0.0).verdict == Verdict.NEW_SESSION
    return check


def after(n, **changes):
    return replace(FIRST, seqno=FIRST.seqno + n, tm_ms=1000 + 4 * n, **changes)


def test_the_next_packet_is_accepted_and_a_gap_is_counted(check):
    assert check.feedback(after(1), HOME, 0.004).n_steps == 1
    assert check.feedback(after(4), HOME, 0.016).n_steps == 3
    assert check.counts['missed_cycles'] == 2


@pytest.mark.parametrize(('step', 'code'), [(0, 'duplicate'), (-3, 'out_of_order')])
def test_replayed_packets_are_ignored(check, step, code):
    judgement = check.feedback(after(step), HOME, 0.004)
    assert judgement.verdict == Verdict.IGNORE
    assert judgement.reason == code


def test_time_that_runs_back_is_ignored(check):
    found = check.feedback(replace(after(1), tm_ms=500), HOME, 0.004)
    assert found.reason == 'time_runs_back'


def test_a_clock_that_was_ahead_for_a_while_is_believed_again_after_a_silence(check):
    # Two packets an hour ahead agree with each other, and are believed; then the clock is right.
    ahead = [replace(after(n), tm_ms=3_600_000 + 4 * n) for n in (1, 2)]
    assert check.feedback(ahead[0], HOME, 0.004).reason == 'ahead'
    assert check.feedback(ahead[1], HOME, 0.008).verdict == Verdict.ACCEPT
    assert check.feedback(after(3), HOME, 0.012).reason == 'time_runs_back'
    assert check.feedback(after(80), HOME, 0.32).verdict == Verdict.NEW_SESSION
    assert check.feedback(after(81), HOME, 0.324).verdict == Verdict.ACCEPT


def test_sequence_and_time_may_wrap(check):
    late = replace(FIRST, seqno=2**32 - 1, tm_ms=2**32 - 2)
    fresh = SessionCheck(SessionLimits())
    fresh.feedback(late, HOME, 0.0)
    wrapped = replace(FIRST, seqno=0, tm_ms=2)
    assert fresh.feedback(wrapped, HOME, 0.004).verdict == Verdict.ACCEPT


def test_a_session_that_starts_anew_is_seen(check):
    restarted = replace(FIRST, seqno=0, tm_ms=2000)
    assert check.feedback(restarted, HOME, 0.01).verdict == Verdict.NEW_SESSION


def test_a_replayed_first_packet_is_no_new_session(check):
    check.feedback(after(5), HOME, 0.02)
    assert check.feedback(replace(FIRST, seqno=0, tm_ms=1000), HOME, 0.03).reason == 'out_of_order'


def test_another_host_or_port_raises_the_alarm(check):
    assert check.sender(('127.0.0.2', 40000), 0.01).verdict == Verdict.ALARM
    assert check.sender(('127.0.0.1', 50000), 0.01).verdict == Verdict.ALARM
    assert check.sender(HOME, 0.01).verdict == Verdict.ACCEPT


def test_a_jump_no_axis_can_make_raises_the_alarm(check):
    jump = after(1, joints_deg=(0.0, 2.0, 0.0, 0.0, 0.0, 0.0))
    assert check.feedback(jump, HOME, 0.004).reason == 'joint_jump'
    slow = after(2, joints_deg=(0.0, 2.5, 0.0, 0.0, 0.0, 0.0))
    assert check.feedback(slow, HOME, 0.008).verdict == Verdict.ACCEPT


def test_a_wrapped_sequence_is_followed_across_a_loss():
    fresh = SessionCheck(SessionLimits())
    fresh.feedback(replace(FIRST, seqno=2**32 - 2, tm_ms=2**32 - 8), HOME, 0.0)
    after_loss = fresh.feedback(replace(FIRST, seqno=1, tm_ms=4), HOME, 0.012)
    assert (after_loss.verdict, after_loss.n_steps) == (Verdict.ACCEPT, 3)
    old = fresh.feedback(replace(FIRST, seqno=2**32 - 1, tm_ms=2**32 - 4), HOME, 0.016)
    assert old.reason == 'out_of_order'


def test_a_controller_that_was_switched_off_and_on_is_believed_after_a_silence(check):
    # Its clock begins anew as well, so only the silence tells it from a replayed packet.
    again = replace(FIRST, seqno=0, tm_ms=0)
    assert check.feedback(again, HOME, 0.1).reason == 'out_of_order'
    assert check.feedback(again, HOME, 0.6).verdict == Verdict.NEW_SESSION


def test_a_packet_too_old_for_an_answer_is_counted_and_is_no_refusal(check):
    assert check.refuse_stale().verdict == Verdict.IGNORE
    assert (check.counts['stale'], check.counts['rejected']) == (1, 0)


@pytest.mark.parametrize('step_ms', [0, 4, 5, 24])
def test_any_rate_and_a_clock_of_whole_milliseconds_are_taken(check, step_ms):
    for number in range(1, 20):
        packet = replace(FIRST, seqno=10 + number, tm_ms=1000 + step_ms * number)
        assert check.feedback(packet, HOME, 0.004 * number).verdict == Verdict.ACCEPT


AWAY = (90.0, 0.0, 0.0, 0.0, 0.0, 0.0)
DAMAGED = {
    'place held': {'planned_deg': AWAY},
    'place measured': {'joints_deg': AWAY},
    'both': {'planned_deg': AWAY, 'joints_deg': AWAY},
    'number far on': {'seqno': 10 + 2**30},
    'number a little on': {'seqno': 10 + 33},
    'clock far on': {'tm_ms': 1000 + 2**30},
    'clock a second on': {'tm_ms': 2000},
    'number and clock': {'seqno': 10 + 250, 'tm_ms': 2008},
}


@pytest.mark.parametrize('kind', DAMAGED)
def test_one_damaged_packet_is_set_aside_and_makes_the_next_ones_no_less_true(check, kind):
    check.feedback(after(1), HOME, 0.004)
    damaged = replace(after(2), **DAMAGED[kind])
    judgement = check.feedback(damaged, HOME, 0.008)
    assert judgement.verdict in (Verdict.IGNORE, Verdict.ALARM)
    for number in range(3, 8):
        found = check.feedback(after(number), HOME, 0.004 * number)
        assert (found.verdict, found.n_steps) == (Verdict.ACCEPT, 2 if number == 3 else 1)


@pytest.mark.parametrize('kind', ['place held', 'number far on', 'clock far on'])
def test_what_the_next_packet_goes_on_from_is_believed(check, kind):
    changed = replace(after(1), **DAMAGED[kind])
    assert check.feedback(changed, HOME, 0.004).verdict == Verdict.IGNORE
    following = replace(changed, seqno=changed.seqno + 1, tm_ms=changed.tm_ms + 4)
    assert check.feedback(following, HOME, 0.008).verdict == Verdict.ACCEPT


def test_a_bridge_that_stood_still_believes_the_controller_that_went_on(check):
    late = replace(after(750), joints_deg=AWAY, planned_deg=AWAY)
    assert check.feedback(late, HOME, 3.02).verdict == Verdict.ACCEPT
