"""Stopped in mid-sweep, the arm is led back by `ama operate`, and the plan may begin again."""

import os

import numpy as np
import pytest

from robot_bridge.operator import AWAY
from test.support.domains import ros_domain
from test.support.operated_cell import (
    AMA,
    ASKED,
    LET_GO,
    PATIENCE_S,
    recover,
    release,
    running_cell,
)
from test.support.terminal import Terminal

pytest.importorskip('rclpy')
pytest.importorskip('oma_msgs')
pytestmark = [pytest.mark.node, pytest.mark.slow, pytest.mark.timeout(400)]

ALLOWED_DEG = 0.2


def test_stopped_in_a_sweep_the_arm_is_led_back_and_the_plan_may_begin_again(drivers, tmp_path):
    domain = ros_domain(24)
    environment = {
        **os.environ,
        'ROS_DOMAIN_ID': str(domain),
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
    }
    # The default plan slides; only shorter.
    duration = 'excitation_planner.duration_s=8.0'
    context = drivers.context_of(domain)
    with running_cell(environment, drivers.free_port(), tmp_path, duration):
        watcher, here = drivers.Operator(context), Terminal([*AMA, 'operate'], environment)
        try:
            _lead_back(here, watcher)
        finally:
            here.close()
            watcher.close()
            context.try_shutdown()


def _lead_back(here, watcher):
    place = release(here)
    planned, start = watcher.last.plan_hash, np.degrees(watcher.joints[-1].position)
    here.hold()
    # Wherever the sweeps have taken it so far that it could not begin again.
    watcher.until(
        lambda: np.abs(np.degrees(watcher.joints[-1].position) - start).max() > 2 * ALLOWED_DEG,
        'a sweep', PATIENCE_S,
    )  # fmt: skip
    here.let_go()
    place = recover(here, here.until(LET_GO, PATIENCE_S, place))
    place = here.until(
        r'away from the start of the plan: axis \d by [\d.]+ deg', PATIENCE_S, place
    )
    place = _held_to_its_end(here, place)
    assert np.abs(np.degrees(watcher.joints[-1].position) - start).max() < 0.05
    # At the start, the plan it went back for is in hand again, and may begin.
    place = here.until(ASKED, PATIENCE_S, here.until('sliding noise', PATIENCE_S, place))
    watcher.until(lambda: watcher.last.plan_hash == planned, 'the plan again')
    assert AWAY not in watcher.last.reason
    here.type('q\n')
    assert here.wait(PATIENCE_S) == 1


def _held_to_its_end(here, place):
    """Lead the arm back; what a busy machine stops on the way is led back from there."""
    for _ in range(5):
        place = here.until('next: the slow way back.*Enter', PATIENCE_S, place)
        here.type('\n')
        # Looked at, released and held like any other.
        place = release(here, here.until('approach, .* deg', PATIENCE_S, place))
        here.hold()
        here.until('at its end|let go: the|not held|not started|ABORTED', PATIENCE_S, place)
        here.let_go()
        if 'HOLDING: the plan is at its end' in here.screen[place:]:
            return place
        place = recover(here, place)
    raise AssertionError(here.screen)
