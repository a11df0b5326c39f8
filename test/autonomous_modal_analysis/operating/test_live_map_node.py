"""`ama map measure --live` in a real terminal, beside `ama up`: one release for a series."""

import json
import os
import re

import numpy as np
import pytest
from typer.testing import CliRunner

from autonomous_modal_analysis.cli import app
from structural_model import load_robot
from test.support.domains import ros_domain
from test.support.operated_cell import AMA, ASKED, HELD, PATIENCE_S, running_cell
from test.support.terminal import Terminal

pytest.importorskip('rclpy')
pytest.importorskip('oma_msgs')
pytestmark = [pytest.mark.node, pytest.mark.slow, pytest.mark.timeout(900)]

COMMON = [
    '--poses', '2', '--record-s', '12', '--sensors', 'sensors_light', '--seed', '4',
    '--accuracy-percent', '0.01',
]  # fmt: skip
MOST_HOLDS = 20
ENDED = 'at its end|let go: the|not held|not started|ABORTED'


@pytest.fixture
def released(tmp_path):
    """Return the folder of a series that was planned, and its hash."""
    shown = CliRunner().invoke(app, ['map', 'measure', '--out', str(tmp_path / 'map'), *COMMON])
    assert shown.exit_code == 0, shown.output
    return tmp_path / 'map', re.search('--release ([0-9a-f]{64})', shown.output)[1]


def test_a_series_is_released_once_and_runs_while_the_key_is_held(released, drivers, tmp_path):
    folder, series_hash = released
    stops = json.loads((folder / 'series.json').read_text())['stops']
    model = load_robot('irb6660_205_190')
    start_deg = np.degrees(model.to_controller(stops[0]['pose_rad'])).tolist()
    domain = ros_domain(26)
    environment = {
        **os.environ,
        'ROS_DOMAIN_ID': str(domain),
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
    }
    context = drivers.context_of(domain)
    command = [*AMA, 'map', 'measure', '--live', '--out', str(folder), *COMMON]
    cell = running_cell(
        environment,
        drivers.free_port(),
        tmp_path,
        'abb_emulator.sensors_file=sensors_light',
        f'abb_emulator.start_controller_deg={start_deg}',
        # A session of guidance begins at the first pose, and must let the arm get to the others.
        'abb_emulator.guidance.max_position_deviation_deg=300.0',
        'excitation_planner.plan_on_start=false',
    )
    with cell:
        watcher = drivers.Operator(context)
        here = Terminal([*command, '--release', series_hash], environment)
        try:
            asked = lead(here)
            assert here.wait(PATIENCE_S) == 0, here.screen
        finally:
            here.close()
            watcher.close()
            context.try_shutdown()
    kept = json.loads((folder / 'map.json').read_text())
    assert [pose['plan_hash'] for pose in kept['poses']] == [stop['plan_hash'] for stop in stops]
    # Only a way to a start from elsewhere, where a busy machine let go, asks for its own release.
    own = {stop['plan_hash'] for stop in stops} | {stop['way_hash'] for stop in stops}
    assert not own & asked
    joints = np.array([message.position for message in watcher.joints])
    for stop in stops:
        away = np.abs(joints - np.array(stop['pose_rad'])).max(axis=1)
        assert away.min() < np.deg2rad(0.3), 'the arm was at every pose'


def lead(here):
    """Be the person: hold when told to, type what is asked for; return hashes typed for."""
    place, asked = 0, set()
    words = f'{HELD}|{ASKED}|Enter does it|Enter plans it|Enter looks again|written:'
    for _ in range(MOST_HOLDS):
        end = here.until(words, 3 * PATIENCE_S, place)
        said = re.findall(words, here.screen[place:end], re.DOTALL)[-1]
        place = end
        if said == 'written:':
            return asked
        if said == ASKED:
            shown = re.findall('hash ([0-9a-f]{64})', here.screen[:end])[-1]
            asked.add(shown)
            here.type(shown[:8] + '\n')
        elif said == HELD:
            here.hold()
            place = here.until(ENDED, PATIENCE_S, place)
            here.let_go()
        else:
            here.type('\n')
    raise AssertionError(here.screen)
