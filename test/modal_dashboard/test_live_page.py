"""The live page in a real browser, told by real topics."""

from dataclasses import replace
import os
from pathlib import Path
import signal
import socket
import subprocess
import sys

import numpy as np
import pytest

pytest.importorskip('rclpy')
pytest.importorskip('oma_msgs')

from diagnostic_msgs.msg import DiagnosticStatus

from modal_core.mode import ModeSet
from modal_core.quality import ChannelQuality, DataQuality
from modal_core.window import Pose
from oma_msgs.msg import BridgeState
from test.support import browser
from test.support.domains import ros_domain
from test.support.live_cell import LiveCell, Results, ROBOT, START_NS
from test.support.page_timing import measure_delays, measure_frames, SHAPES, SPECTRUM

pytestmark = [
    pytest.mark.node,
    pytest.mark.skipif(
        browser.find_browser() is None,
        reason='no Chromium: apt-get install chromium to test the page in a browser',
    ),
]
SCREENS = ('health', 'spectrum', 'poles', 'modes', 'mac', 'trends', 'cell', 'log')
HOSTILE = '</td></script><script>window.hacked=1</script><img src=x onerror="window.hacked=1">'
PICTURES = os.environ.get('AMA_PICTURES')
"""Folder that the pictures of docs/images are written to."""


@pytest.fixture(scope='module')
def page():
    with browser.browser_page() as opened:
        yield opened


@pytest.fixture
def cell(ros_context):
    cells = []

    def make(**parameters):
        cells.append(LiveCell(ros_context, **parameters))
        return cells[-1]

    yield make
    for each in cells:
        each.close()


def look(page, url, **options):
    # The page of a server that is gone tries to reach it.
    page.open('about:blank')
    page.problems.clear()
    page.requests.clear()
    page.open(url, **options)
    return page


def text(page):
    return page.evaluate('document.body.innerText')


def show(page, screen):
    page.evaluate(f'window.location.hash = "{screen}"')
    page.until(f'document.getElementById("tab-{screen}").ariaSelected === "true"')
    # Drawn at the next frame.
    page.evaluate(
        'new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))'
    )


def inked(page):
    """Return how many pixels of each canvas on the screen are painted."""
    return page.evaluate("""
        [...document.querySelectorAll('main :is(.uplot, .card, .strip) canvas')].map((canvas) => {
        const data = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
        let count = 0; for (let i = 3; i < data.length; i += 4) if (data[i]) count++; return count;
        })""")


def tell_all(cell, n_windows=4, **changes):
    """Tell everything a page can show; some of it while nobody looks."""
    results = Results()
    for _ in range(n_windows):
        last = results.next(**changes)
        cell.publish(last)
    cell.tell_state()
    cell.tell_check('/oma_identifier: samples', 'OK', windows='4')
    cell.tell_check(
        '/modal_history: alarms', 'NATURAL_FREQUENCY_CHANGED', DiagnosticStatus.WARN,
        **{'alarm 1': 'mode 2 fell by 1.2 % since Tuesday'},
    )  # fmt: skip
    return results, last


@pytest.mark.parametrize(
    ('kind', 'width', 'dark'),
    [
        pytest.param('light', 1280, False, marks=pytest.mark.smoke),
        pytest.param('dark', 1280, True, marks=pytest.mark.slow),
        pytest.param('phone', 390, False, marks=pytest.mark.slow),
    ],
)
def test_a_late_browser_is_shown_every_screen(page, cell, kind, width, dark):
    live = cell()
    results, last = tell_all(live)
    look(page, live.url, width=width, dark=dark)
    page.until('document.getElementById("newest").textContent.includes("window 3")')
    expected = {
        'health': ['base_front.x', 'signal clipped', 'left out', '/oma_identifier: samples'],
        'spectrum': ['Singular values of the responses, window 3'],
        'poles': ['belongs to a mode', 'too few orders agree'],
        'modes': ['Modes of window 3', 'harmonic', '± '],
        'mac': ['Between the modes of this window', 'Against window 2', '1.00'],
        'trends': ['over 4 windows', 'alarm 1: mode 2 fell by 1.2 %', 'Mode 1'],
        'cell': ['running', 'released by the operator', '40 %', 'band limited noise', '11.20'],
        'log': ['window 0: 7 modes', 'bridge running', 'plan c0ffee', 'NATURAL_FREQ'],
    }
    for screen in SCREENS:
        show(page, screen)
        for words in expected[screen]:
            page.until(f'document.body.innerText.includes({words!r})')
        assert all(count > 200 for count in inked(page)), screen
        assert page.evaluate(
            'document.documentElement.scrollWidth <= document.documentElement.clientWidth'
        ), screen
        if PICTURES:
            page.screenshot(Path(PICTURES) / f'live_{screen}_{kind}.png', highest=1200)
    show(page, 'modes')
    assert page.evaluate('document.querySelectorAll("main .card canvas").length') == len(
        results.frequency_hz
    )
    panels = page.evaluate(
        '[...document.querySelectorAll(".panels svg")]'
        '.map((each) => each.querySelectorAll(".point").length)'
    )
    assert panels == [len(results.names)] * len(panels) and len(panels) == len(
        results.frequency_hz
    )
    first = last.modes.modes[0]
    assert f'{first.frequency_hz:.4f}'[:4] in text(page)
    assert page.problems == []
    base = live.url
    assert set(page.requests) == {base, f'{base}live.css', f'{base}live.js'}


def test_trends_are_shown_pose_by_pose(page, cell):
    """Two poses in turn: all windows at first, those of one pose when it is chosen."""
    live = cell()
    results = Results()
    for number in range(6):
        pose = results.pose
        turned = np.asarray(pose.position) + (0.5 if number % 3 == 2 else 0.002 * number)
        live.publish(results.next(pose=Pose(pose.joint_names, turned, pose.position_range)))
    look(page, live.url)
    show(page, 'trends')
    page.until('document.body.innerText.includes("over 6 windows")')
    offered = '[...document.querySelectorAll("main select option")].map((each) => each.text)'
    assert page.evaluate(offered)[0] == 'all 2' and len(page.evaluate(offered)) == 3
    for option, count in ((2, 2), (1, 4), (0, 6)):
        page.evaluate(
            '(() => { const choice = document.querySelector("main select");'
            f' choice.selectedIndex = {option}; choice.dispatchEvent(new Event("change")); }})()'
        )
        page.until(f'document.body.innerText.includes("over {count} windows")')
    # The choice stays while results come.
    page.evaluate(
        '(() => { const choice = document.querySelector("main select");'
        ' choice.selectedIndex = 1; choice.dispatchEvent(new Event("change")); })()'
    )
    live.publish(results.next())
    page.until('document.body.innerText.includes("over 5 windows")')
    assert page.problems == []


def test_shapes_move_on_the_arm_and_the_page_can_be_stopped(page, cell):
    live = cell(robot=ROBOT)
    results, _ = tell_all(live)
    look(page, live.url, reduced=False)
    show(page, 'modes')
    page.until('document.querySelectorAll("main .card:not(.flat)").length > 3')
    pixels = 'document.querySelector("main .card canvas").toDataURL()'
    before = page.evaluate(pixels)
    page.until(f'{pixels} !== {before!r}')
    page.key('p')
    page.until('document.getElementById("link").textContent === "paused"')
    live.publish(results.next())
    page.until('document.getElementById("newest").textContent.includes("now window 4")')
    assert 'Modes of window 3' in text(page)
    page.key('p')
    page.until('document.body.innerText.includes("Modes of window 4")')
    assert page.problems == []


def test_the_arm_is_drawn_in_every_frame_and_each_result_is_seen(page, cell, record_property):
    """Shares and counts are tested; how fast it is depends on the machine, and is printed.

    `python -m benchmarks.page` keeps the figures of an idle one.
    """
    live = cell(robot=ROBOT)
    results, _ = tell_all(live)
    look(page, live.url, reduced=False)
    show(page, 'modes')
    page.until('document.querySelectorAll("main .card:not(.flat)").length > 3')
    frames = measure_frames(page, 120)
    assert frames.drawn > 0.95
    shapes_ms = measure_delays(page, live, results, SHAPES, 3)
    show(page, 'spectrum')
    delays_ms = measure_delays(page, live, results, SPECTRUM, 5)
    assert len(delays_ms) == 5 and np.all(delays_ms > 0.0) and np.all(shapes_ms > 0.0)
    for name, value in (
        ('frames a second', frames.rate_hz),
        ('of 60', frames.rate_hz / 60.0),
        ('median from result to pixel [ms]', np.median(delays_ms)),
        ('of 50 ms', np.median(delays_ms) / 50.0),
        ('to the shapes on the arm [ms]', np.median(shapes_ms)),
    ):
        print(f'{name}: {value:.3g}')
        record_property(name, float(value))
    assert page.problems == []


def test_two_browsers_are_told_the_same_and_one_may_go(page, cell):
    live = cell(robot='')
    results, _ = tell_all(live, 1)
    with browser.browser_page() as other:
        for each in (page, other):
            look(each, live.url)
            show(each, 'trends')
            each.until('document.body.innerText.includes("over 1 window")')
        assert live.node.server.n_viewers == 2
        live.publish(results.next())
        for each in (page, other):
            each.until('document.body.innerText.includes("over 2 windows")')
        assert other.problems == []
    live.until(lambda: live.node.server.n_viewers == 1)
    live.publish(results.next())
    page.until('document.body.innerText.includes("over 3 windows")')


def test_a_recording_that_is_played_again_begins_a_new_trend(page, cell):
    live = cell(robot='')
    results, _ = tell_all(live, 3)
    look(page, live.url)
    show(page, 'trends')
    page.until('document.body.innerText.includes("over 3 windows")')
    early = results.next()
    length_ns = early.end_ns - early.start_ns
    again = replace(early, start_ns=START_NS, end_ns=START_NS + length_ns)
    live.publish(again)
    page.until('document.querySelector("main").innerText.includes("over 1 window\\n")')
    assert page.problems == []


def test_keys_choose_screens_and_the_theme(page, cell):
    live = cell(robot='')
    look(page, live.url)
    for number, screen in enumerate(SCREENS, 1):
        page.key(str(number))
        page.until(f'window.location.hash === "#{screen}"')
    page.evaluate('document.getElementById("tab-log").focus()')
    page.key('ArrowRight')
    page.until('window.location.hash === "#health"')
    assert page.evaluate('document.activeElement.id') == 'tab-health'
    page.key('t')
    page.until('document.documentElement.dataset.theme === "dark"')
    assert page.problems == []


def test_a_reader_stays_where_he_is_while_checks_come(page, cell):
    live = cell(robot='')
    tell_all(live)
    look(page, live.url, width=390)
    page.until('document.querySelectorAll("main .scroll").length === 2')
    page.evaluate('window.box = document.querySelector("main .scroll")')
    page.evaluate('box.focus(); box.scrollLeft = 40')
    page.until('!box.isConnected')
    assert page.evaluate('document.activeElement === document.querySelector("main .scroll")')
    assert page.evaluate('document.activeElement.scrollLeft') == 40


def test_names_are_only_ever_text(page, cell):
    """Of sensors, methods, checks, controllers, robots, joints: whoever publishes may send it."""
    live = cell(robot='')
    results = Results(rename=lambda name: f'{HOSTILE}{name}')
    page.evaluate('window.hacked = 0')
    for _ in range(2):
        given = results.next(
            quality=DataQuality(False, HOSTILE, flags=(HOSTILE,)),
            modes=ModeSet((), results.names, HOSTILE),
        )
        live.publish(given)
        live.publish(results.next())
    live.tell_state(reason=HOSTILE, state=BridgeState.ABORTED)
    live.tell_check(f'/x: {HOSTILE}', HOSTILE, DiagnosticStatus.ERROR, **{HOSTILE: HOSTILE})
    look(page, live.url)
    page.until('document.getElementById("newest").textContent.includes("window 3")')
    for screen in SCREENS:
        show(page, screen)
        assert page.evaluate('window.hacked') is None, screen
        assert page.evaluate('document.querySelectorAll("main script, main img").length') == 0
    page.until('document.body.innerText.includes("bridge aborted")')
    assert 'onerror' in text(page)
    assert page.problems == []


@pytest.mark.parametrize('width', [1280, 420])
def test_a_name_without_end_makes_no_row_without_end(page, cell, width):
    endless = 'sensor_with_an_endless_name_' * 30
    live = cell(robot='')
    results = Results(rename=lambda name: f'{endless}{name}')
    channels = tuple(
        ChannelQuality(name, rms=1.0, kurtosis=3.0, flags=(endless,)) for name in results.names
    )
    live.publish(results.next(quality=DataQuality(True, '', (endless,), channels)))
    live.tell_check(f'/x: {endless}', endless, DiagnosticStatus.ERROR, **{endless: endless})
    look(page, live.url, width=width)
    page.until('document.getElementById("newest").textContent.includes("window 0")')
    for screen in SCREENS:
        show(page, screen)
        rows = page.evaluate(
            '[...document.querySelectorAll("main tr")].map((row) => row.offsetHeight)'
        )
        assert max(rows, default=0) < 200, screen
        wide = page.evaluate('document.documentElement.scrollWidth - window.innerWidth')
        assert wide <= 0, screen


def test_a_window_that_cannot_be_identified_says_why(page, cell):
    live = cell(robot='')
    results = Results()
    empty = ModeSet((), results.names)
    quality = DataQuality(identifiable=False, reason='the arm was moving')
    live.publish(results.next(modes=empty, harmonics=empty, quality=quality))
    look(page, live.url)
    page.until('document.body.innerText.includes("could not be identified: the arm was moving")')
    for screen in SCREENS:
        show(page, screen)
    assert page.problems == []


def test_a_page_of_another_origin_is_told_nothing(page, cell):
    live = cell(robot='')
    tell_all(live, 1)
    page.open('about:blank')
    for address in ('127.0.0.1', 'localhost'):
        url = f'ws://{address}:{live.node.server.port}/live'
        heard = page.evaluate(f"""new Promise((done) => {{
            const socket = new WebSocket('{url}');
            socket.onmessage = () => done('told'); socket.onerror = () => done('refused');
            }})""")
        assert heard == 'refused'


def free_port():
    with socket.socket() as probe:
        probe.bind(('127.0.0.1', 0))
        return probe.getsockname()[1]


def start_node(port):
    return subprocess.Popen(
        [
            sys.executable, '-m', 'modal_dashboard.dashboard_node',
            '--ros-args', '-p', f'port:={port}', '-p', "robot:=''",
        ],
        env={**os.environ, 'ROS_DOMAIN_ID': str(ros_domain())},
        stdout=subprocess.PIPE,
        text=True,
    )  # fmt: skip


@pytest.mark.slow
def test_a_server_that_is_killed_and_comes_back_is_found_again(page, cell):
    """The page says that it is lost, keeps what it knew, and is told all that is latched."""
    live, port = cell(robot=''), free_port()
    results = Results()
    live.publish(results.next())
    process = start_node(port)
    try:
        live.until(lambda: live.publishers['results'].get_subscription_count() == 2)
        look(page, f'http://127.0.0.1:{port}/')
        show(page, 'modes')
        page.until('document.body.innerText.includes("Modes of window 0")')
        process.send_signal(signal.SIGKILL)
        process.wait()
        page.until('document.getElementById("link").textContent.includes("connection lost")')
        assert 'Modes of window 0' in text(page)
        live.publish(results.next())
        process = start_node(port)
        page.until('document.body.innerText.includes("Modes of window 1")')
        page.until('document.getElementById("link").textContent === "live"')
    finally:
        process.kill()
        process.wait()


def test_a_page_for_other_machines_asks_for_a_token(page, cell):
    live = cell(robot='', address='0.0.0.0')
    token = live.url.partition('?token=')[2]
    assert len(token) >= 32
    here = f'http://127.0.0.1:{live.node.server.port}/'
    look(page, here)
    assert 'open the page by the address that has the token' in text(page)
    look(page, f'{here}?token={token}')
    page.until('document.getElementById("link").textContent === "live"')
    # What is in the address bar may be shown to others.
    assert page.evaluate('window.location.search') == ''
    assert page.problems == []


def test_what_makes_no_sense_is_refused_and_said(page, cell):
    live = cell(robot='')
    results, last = tell_all(live, 1)
    broken = np.array([3.0, 2.0, 1.0])
    spectrum = type(last.spectrum)(broken, np.ones((3, 2)))
    live.publish(results.next(spectrum=spectrum))
    live.until(lambda: live.node.digest.n_refused == 1)
    assert live.node.findings()[0][0] == 'MESSAGE_REFUSED'
    look(page, live.url)
    show(page, 'log')
    page.until('document.body.innerText.includes("a message that cannot be shown")')
    live.publish(results.next())
    page.until('document.getElementById("newest").textContent.includes("window 2")')
