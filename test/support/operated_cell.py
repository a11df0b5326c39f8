"""`ama up` beside a person at a terminal."""

from contextlib import contextmanager
import re
import signal
import subprocess
import sys

from test.support.child import end_with_parent

AMA = [sys.executable, '-m', 'autonomous_modal_analysis']
PATIENCE_S = 120.0
MOST_ATTEMPTS = 3
HELD = 'hold the SPACE bar'
ASKED = 'type the first'
OFFERED = 'Enter does it'
LET_GO = 'let go: the motion is stopped'
AT_ITS_END = r'HOLDING: the plan is at its end .\d+ beats'


@contextmanager
def running_cell(environment, port, folder, *parameters):
    """Run `ama up`: shipped parameters, but for its port and these."""
    options = [word for each in parameters for word in ('--parameter', each)]
    process = subprocess.Popen(
        [*AMA, 'up', '--egm-port', str(port), '--log-folder', str(folder), *options],
        env=environment,
        preexec_fn=end_with_parent,
    )
    try:
        yield process
    finally:
        process.send_signal(signal.SIGTERM)
        status = process.wait(60.0)
    assert status == 0


def release(terminal, after=0):
    """Type the hash that is shown; return the place on the screen behind the answer.

    A machine that stands still loses the controller's stream, and offers to begin it again.
    """
    place = terminal.until(f'{ASKED}|{OFFERED}', PATIENCE_S, after)
    while terminal.screen[:place].endswith(OFFERED):
        terminal.type('\n')
        place = terminal.until(f'{ASKED}|{OFFERED}', PATIENCE_S, place)
    terminal.type(re.findall('hash ([0-9a-f]{64})', terminal.screen)[-1][:8] + '\n')
    return terminal.until(HELD, PATIENCE_S, place)


def recover(terminal, after):
    """Reset what stopped; return the place on the screen behind it."""
    place = terminal.until(f'next: reset it.*{OFFERED}', PATIENCE_S, after)
    terminal.type('\n')
    return place


def run_held(terminal, watcher, drivers, after=0):
    """Release and hold the key until the arm moves; return the place on the screen behind it.

    A machine that stands still for longer than a key may pause has let go, and says so: what a
    person does then is to hold again.
    """
    for _ in range(MOST_ATTEMPTS):
        place = release(terminal, after)
        watcher.joints.clear()
        terminal.hold()
        if moving(watcher, drivers):
            return place
        terminal.let_go()
        place = terminal.until(LET_GO, PATIENCE_S, place)
        after = recover(terminal, place)
    raise AssertionError(f'let go {MOST_ATTEMPTS} times: {terminal.screen}')


def hold_to_the_end(terminal, after):
    """Hold a released plan's key until its end, again where the machine stood still."""
    for _ in range(MOST_ATTEMPTS):
        terminal.hold()
        place = terminal.until(f'{AT_ITS_END}|{LET_GO}', PATIENCE_S, after)
        terminal.let_go()
        if not terminal.screen[:place].endswith(LET_GO):
            return
        after = release(terminal, recover(terminal, place))
    raise AssertionError(f'let go {MOST_ATTEMPTS} times: {terminal.screen}')


def moving(watcher, drivers, progress=0.15):
    """Wait until so much of the plan has been played; return False where it was stopped."""
    state = drivers.BridgeState
    watcher.until(lambda: watcher.last.state != state.ABORTED, 'release', PATIENCE_S)
    watcher.until(
        lambda: (
            watcher.last.state == state.ABORTED
            or (watcher.last.state == state.RUNNING and watcher.last.progress > progress)
        ),
        'motion',
        PATIENCE_S,
    )
    return watcher.last.state == state.RUNNING
