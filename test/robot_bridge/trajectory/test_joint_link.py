"""Which joint states are believed: one publisher's, in its order, without jumps."""

import math
import sys
import threading

import numpy as np
import pytest

from robot_bridge.egm import SessionLimits
from robot_bridge.trajectory import JointLink

PERIOD_NS = 5_000_000
FASTEST_DEG_S = 100.0


class Heard:
    """A link whose alarms and accepted angles are kept."""

    def __init__(self, model):
        self.alarms, self.angles = [], []
        self.home = np.array(model.pose('P1'))
        self.names = list(model.joint_names)
        limits = SessionLimits(cycle_s=0.005, max_speed_deg_s=(FASTEST_DEG_S,) * 6)
        self.link = JointLink(model, limits, self.answer, self.alarms.append, lambda _: None)

    def answer(self, feedback, judgement, now_s, receipt_ns):
        self.angles.append((feedback.joints_deg[0], judgement.n_steps))

    def say(self, step, axis_1_deg=0.0, number=None, late_ns=0):
        position = self.home.copy()
        position[0] += math.radians(axis_1_deg)
        stamp_ns = 10**18 + round(step * PERIOD_NS) - late_ns
        self.link.take(stamp_ns, self.names, position.tolist(), 0, number)


@pytest.fixture
def heard(model):
    heard = Heard(model)
    for step in range(3):
        heard.say(step, number=100 + step)
    return heard


def test_motion_as_fast_as_the_arm_moves_at_any_rate_and_after_a_loss_is_taken(heard):
    steps, angle = [3, 3.5, 3.7, 5, 9, 20], 0.0
    before = 2
    for number, step in enumerate(steps):
        angle += FASTEST_DEG_S * (step - before) * PERIOD_NS / 1e9
        heard.say(step, angle, number=103 + number)
        before = step
    assert not heard.alarms
    assert [n for _, n in heard.angles[-3:]] == [1, 4, 11]


def test_a_place_the_arm_cannot_have_reached_raises_the_alarm_and_is_not_taken(heard):
    n = len(heard.angles)
    heard.say(3, 3.0, number=103)
    assert 'jump farther than the arm moves' in heard.alarms[0]
    assert len(heard.angles) == n
    heard.say(4, 0.0, number=104)
    assert len(heard.angles) == n + 1


@pytest.mark.parametrize('number', [7, 102])
@pytest.mark.parametrize('late_ns', [0, PERIOD_NS // 2])
def test_a_second_publisher_raises_the_alarm_wherever_it_says_the_arm_is(heard, number, late_ns):
    heard.say(3, 0.0, number=number, late_ns=late_ns)
    assert 'two publishers' in heard.alarms[0]


def test_a_second_publisher_with_higher_numbers_is_noticed_by_what_the_first_says_next(heard):
    heard.say(2.5, 0.0, number=5000)
    assert not heard.alarms
    heard.say(3, 0.0, number=103)
    assert 'two publishers' in heard.alarms[0]


@pytest.mark.parametrize('ahead', [10, 40])
def test_stamps_ahead_of_time_hide_nothing_where_the_middleware_numbers_no_messages(model, ahead):
    heard = Heard(model)
    for step in range(20):
        heard.say(step)
        heard.say(step + ahead, -2.0)
    assert heard.alarms and 'run back in time' in heard.alarms[0]


@pytest.mark.parametrize('back_ns', [300_000, PERIOD_NS, 10**10])
def test_stamps_that_run_back_raise_the_alarm(heard, back_ns):
    heard.say(2, number=103, late_ns=back_ns)
    assert 'run back in time' in heard.alarms[0]


def test_a_clock_that_stands_still_is_no_contradiction(heard):
    n = len(heard.angles)
    heard.say(2, 1.0, number=103)
    assert not heard.alarms and len(heard.angles) == n


def test_a_clock_that_went_on_by_an_hour_is_believed_at_the_second_message(heard):
    n = len(heard.angles)
    for step in range(4):
        heard.say(720_000 + step, number=103 + step)
    assert not heard.alarms and len(heard.angles) == n + 3


def test_the_rate_is_told_while_joint_states_come(heard):
    """The bridge asks on another thread; what came in between had ended it."""
    interval_s, over = sys.getswitchinterval(), threading.Event()

    def come():
        try:
            for step in range(3, 4000):
                heard.say(step, number=100 + step)
        finally:
            over.set()

    sys.setswitchinterval(1e-6)
    try:
        thread = threading.Thread(target=come)
        thread.start()
        while not over.is_set():
            assert heard.link.update_rate_hz in (0.0, pytest.approx(200.0))
        thread.join()
    finally:
        sys.setswitchinterval(interval_s)
