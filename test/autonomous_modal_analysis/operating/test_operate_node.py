"""`ama operate` in a real terminal, beside `ama up` as it is shipped: a person runs the arm."""

import os
import re
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from test.support.child import end_with_parent
from test.support.domains import ros_domain
from test.support.operated_cell import (
    AMA,
    ASKED,
    hold_to_the_end,
    LET_GO,
    moving,
    PATIENCE_S,
    recover,
    release,
    run_held,
    running_cell,
)
from test.support.terminal import Terminal

pytest.importorskip('rclpy')
pytest.importorskip('oma_msgs')
pytestmark = [pytest.mark.node, pytest.mark.slow, pytest.mark.timeout(400)]

STILL_DEG = 2e-3
# Stated: 0.3 s after the last repeat the beats end, 0.13 s later the bridge stops, in 0.05 s.
# The rest is the emulated drive, and this machine.
STOPPED_S = 1.5


@pytest.fixture(scope='module')
def environment():
    own = {'ROS_DOMAIN_ID': str(ros_domain(23)), 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}
    return {**os.environ, **own}


@pytest.fixture(scope='module')
def cell(environment, drivers, tmp_path_factory):
    """Run `ama up`: shipped parameters, but for its port, and a plan that is soon over.

    The plan stays within the start tolerance, so that what was stopped can begin again.
    """
    folder = tmp_path_factory.mktemp('cell')
    with running_cell(
        environment,
        drivers.free_port(),
        folder,
        'excitation_planner.duration_s=6.0',
        'excitation_planner.signal=band_limited_noise',
        'excitation_planner.require_full_rank=false',
    ) as process:
        yield process


@pytest.fixture(scope='module')
def watcher(cell, environment, drivers):
    """Return a node that sees states and joints of the cell."""
    context = drivers.context_of(int(environment['ROS_DOMAIN_ID']))
    made = drivers.Operator(context)
    yield made
    made.close()
    context.try_shutdown()


@pytest.fixture
def terminal(environment, cell):
    opened = []

    def open_one(*options):
        opened.append(Terminal([*AMA, 'operate', *options], environment))
        return opened[-1]

    yield open_one
    for each in opened:
        each.close()


def stopped_after_s(watcher, let_go_s):
    """Return how long after a time [s] of the monotonic clock the arm stood, by its joints."""
    time.sleep(STOPPED_S + 1.0)
    offset_s = time.time() - time.monotonic()
    joints = list(watcher.joints)
    stamps_s = np.array([m.header.stamp.sec + 1e-9 * m.header.stamp.nanosec for m in joints])
    angles_deg = np.degrees([m.position for m in joints])
    still = np.abs(angles_deg - angles_deg[-1]).max(axis=1) < STILL_DEG
    return stamps_s[~still].max() - offset_s - let_go_s


def test_one_command_a_full_run_and_what_it_found(terminal, watcher, drivers):
    here = terminal()
    place = here.until(ASKED, PATIENCE_S)
    assert 'an emulated arm' in here.screen and 'fastest point' in here.screen
    here.type('00000000\n')
    place = here.until('not the hash of this plan', PATIENCE_S, place)
    here.type('\n')
    place = release(here, place)
    watcher.joints.clear()
    here.type(' ')  # one stroke is no hold
    time.sleep(2.0)
    assert watcher.last.state == drivers.BridgeState.ARMED
    hold_to_the_end(here, place)
    assert here.wait(PATIENCE_S) == 0
    angles_deg = np.degrees([message.position for message in watcher.joints])
    assert np.ptp(angles_deg, axis=0).max() > 0.03
    assert re.search(r'window \d+ from .*#\d+ [\d.]+', here.screen), here.screen


def test_letting_go_stops_within_the_stated_time_and_the_way_back_is_named(
    terminal, watcher, drivers
):
    here = terminal()
    place = run_held(here, watcher, drivers)
    assert stopped_after_s(watcher, here.let_go()) < STOPPED_S
    assert watcher.last.state == drivers.BridgeState.ABORTED
    place = recover(here, here.until(LET_GO, PATIENCE_S, place))
    # And on: a new release, for another key to stop.
    place = run_held(here, watcher, drivers, place)
    here.type('x')
    assert stopped_after_s(watcher, time.monotonic()) < STOPPED_S
    here.let_go()
    place = recover(here, place)
    # The other way out: Ctrl-C.
    run_held(here, watcher, drivers, place)
    here.type('\x03')
    here.let_go()
    assert here.wait(PATIENCE_S) == 130
    watcher.until(lambda: watcher.last.state == drivers.BridgeState.ABORTED, 'abort')
    # Refused while the arm is still slowing down.
    watcher.until(lambda: watcher.reset().success, 'reset', pause_s=0.2)


@pytest.mark.parametrize('sign', [signal.SIGKILL, signal.SIGSTOP])
def test_an_operator_program_that_is_gone_or_frozen_holds_nothing(
    sign, terminal, watcher, drivers
):
    here = terminal()
    run_held(here, watcher, drivers)
    here.process.send_signal(sign)
    watcher.until(lambda: watcher.last.state == drivers.BridgeState.ABORTED, 'abort', 10.0)
    assert 'heartbeat is lost' in watcher.last.reason
    # Refused while the arm is still slowing down.
    watcher.until(lambda: watcher.reset().success, 'reset', pause_s=0.2)


@pytest.fixture
def pad(environment):
    """Yield a function that presses, or lets go, button 2 of a joystick on /pad."""
    process = subprocess.Popen(
        [sys.executable, '-m', 'test.support.joystick', '/pad', '3'],
        env=environment,
        stdin=subprocess.PIPE,
        preexec_fn=end_with_parent,
    )

    def press(down):
        process.stdin.write(b'1\n' if down else b'0\n')
        process.stdin.flush()

    yield press
    process.stdin.close()
    assert process.wait(PATIENCE_S) == 0


def test_a_button_of_a_joystick_holds_to_run(terminal, watcher, drivers, pad):
    here = terminal('--joy', '--joy-topic', '/pad', '--button', '2')
    place = here.until(ASKED, PATIENCE_S)
    here.type(re.findall('hash ([0-9a-f]{64})', here.screen)[-1][:8] + '\n')
    place = here.until('hold button 2 down', PATIENCE_S, place)
    pad(True)
    while watcher.last.state != drivers.BridgeState.RUNNING:
        # A machine that stands still lets go, and says so: what a person does then.
        if 'let it go first' in here.screen[place:]:
            pad(False)
            place = here.until('hold button 2 down', PATIENCE_S, len(here.screen))
            pad(True)
        assert 'not held' not in here.screen[place:], here.screen
        time.sleep(0.02)
    assert moving(watcher, drivers), here.screen
    pad(False)
    place = recover(here, here.until(LET_GO, PATIENCE_S, place))
    place = here.until(ASKED, PATIENCE_S, place)
    here.type('q\n')
    assert here.wait(PATIENCE_S) == 1


def test_without_a_terminal_it_says_what_else_to_hold(environment, cell):
    run = subprocess.run(
        [*AMA, 'operate'],
        env=environment,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
    )
    assert run.returncode == 2
    assert '--joy' in run.stderr and 'Traceback' not in run.stderr
