"""`ama map` on the emulated arm: released once, killed at any time, gone on with."""

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from abb_emulator.run_plan import ArmOptions
from autonomous_modal_analysis.campaigns.emulated_player import EmulatedPlayer
from autonomous_modal_analysis.cli import app
from autonomous_modal_analysis.mapping import MappingFolder, MapWish, measure, plan_series
from machining.task import read_tool_modes
from modal_core.errors import MapError, PlanError
from structural_model import load_layout, load_robot
from workspace_map import Arm, load_map, receptance, ToolPoint, WorkspaceMap

ROBOT, SENSORS = 'irb6660_205_190', 'sensors_light'
WISH = MapWish(poses=2, record_s=12.0, accuracy=1e-4, seed=4)


@pytest.fixture(scope='module')
def start():
    model, layout = load_robot(ROBOT), load_layout(ROBOT, SENSORS)
    return WorkspaceMap(Arm(model, layout.channels, ToolPoint('flange')), 60.0)


@pytest.fixture(scope='module')
def layout():
    return load_layout(ROBOT, SENSORS)


@pytest.fixture(scope='module')
def series(start, layout):
    return plan_series(start.arm.model, layout, start, WISH)


@pytest.mark.slow
def test_a_series_is_within_limits_and_its_hash_binds_every_motion(start, layout, series):
    model = start.arm.model
    again = plan_series(model, layout, start, WISH)
    assert again.series_hash == series.series_hash
    assert len(series.stops) == 2
    for stop in series.stops:
        model.check_pose(np.array(stop.pose_rad))
        assert series.excitation(model, layout, WISH, stop).plan_hash == stop.plan_hash
    other = plan_series(model, layout, start, MapWish(poses=2, record_s=12.0, seed=5))
    assert other.series_hash != series.series_hash
    with pytest.raises(PlanError, match='not the motion that was released'):
        series.excitation(model, layout, MapWish(record_s=12.0, seed=5), series.stops[0])


@pytest.mark.slow
def test_a_budget_of_time_is_kept(start, layout, series):
    tight = MapWish(poses=2, record_s=12.0, accuracy=1e-4, seed=4, budget_s=60.0)
    planned = plan_series(start.arm.model, layout, start, tight)
    assert planned.seconds <= 60.0


class KilledError(Exception):
    """As if the process had been killed."""


@pytest.mark.slow
def test_what_is_killed_goes_on_and_nothing_is_lost(start, layout, series, tmp_path):
    """In the middle of a recording, and between a recording and the map."""
    folder = MappingFolder(tmp_path, layout)
    options = ArmOptions(robot=ROBOT, sensors_file=SENSORS)
    player, played = EmulatedPlayer(options), []

    def killed_while_recording(plan, path, progress):
        path.write_bytes(b'half a recording')
        raise KilledError

    def play(plan, path, progress):
        played.append(plan.plan_hash)
        player.play(plan, path, progress)

    def killed_after_recording(plan, path, progress):
        play(plan, path, progress)
        raise KilledError

    for each in (killed_while_recording, killed_after_recording):
        with pytest.raises(KilledError):
            measure(folder, start, series, WISH, each, lambda _: None)
    told = []
    known = measure(folder, start, series, WISH, play, told.append)
    assert all('modes; frequencies known to' in line for line in told)
    assert played == [stop.plan_hash for stop in series.stops], 'each once'
    assert [pose.plan_hash for pose in known.measured] == played
    again, made_by = load_map(folder.map_path, start.arm.model, layout)
    assert made_by == series.series_hash
    assert len(again.measured) == 2
    kept = measure(folder, start, series, WISH, killed_while_recording, lambda _: None)
    assert len(kept.measured) == 2
    other = plan_series(start.arm.model, layout, start, MapWish(poses=2, record_s=12.0, seed=5))
    with pytest.raises(MapError, match='a map of another series'):
        measure(folder, start, other, WISH, play, lambda _: None)
    true = start.arm.model
    errors = []
    for pose in known.measured:
        found = known.predict(pose.q).frequency_hz
        expected = true.modes(pose.q).frequency_hz[: len(found)]
        errors += list(np.abs(np.log(found / expected[: len(found)])))
    assert np.median(errors) < 0.01


def run(*arguments):
    return CliRunner().invoke(app, ['map', *arguments], catch_exceptions=True)


@pytest.mark.slow
def test_nothing_moves_without_a_release(tmp_path):
    common = ['measure', '--out', str(tmp_path), '--poses', '2', '--record-s', '12']
    common += ['--sensors', SENSORS, '--seed', '4']
    shown = run(*common)
    assert shown.exit_code == 0
    assert '--release' in shown.output
    assert [path.name for path in Path(tmp_path).iterdir()] == ['series.json']
    wrong = run(*common, '--release', '0' * 64)
    assert 'not the hash of this series' in str(wrong.exception)
    assert [path.name for path in Path(tmp_path).iterdir()] == ['series.json']


def test_predict_says_modes_with_sigma_and_refuses_beyond_what_it_knows(tmp_path):
    from benchmarks.workspace_map.hidden_arms import hidden_arm, known_arm
    from workspace_map import save_map

    arm = known_arm()
    file = tmp_path / 'map.json'
    near = hidden_arm(101).measured(arm.model.pose('P1'))
    save_map(file, WorkspaceMap(arm, 60.0, (near,) * 2), load_layout(ROBOT))
    found = run('predict', '--map', str(file), '--pose-deg', 'P1', '--json')
    content = json.loads(found.output)
    prediction = tmp_path / 'p1.json'
    prediction.write_text(found.output)
    modes = read_tool_modes(prediction)
    assert content['modes'][0]['frequency_hz'] == pytest.approx(near.frequency_hz[0], rel=0.02)
    n = len(content['modes'])
    assert modes.n_modes == n
    line_hz = np.linspace(5.0, 50.0, 20)
    whole = load_map(file, arm.model, load_layout(ROBOT))[0].predict(arm.model.pose('P1'))
    expected = receptance(whole, line_hz) - whole.residual
    assert modes.receptance(line_hz) == pytest.approx(expected, rel=1e-6)
    relative = [each['frequency_std_hz'] / each['frequency_hz'] for each in content['modes']]
    assert np.diag(modes.covariance)[::5] == pytest.approx(np.square(relative), rel=1e-6)
    far = run('predict', '--map', str(file), '--pose-deg', 'P3')
    assert 'too far from every measured pose' in str(far.exception)
    outside = run('predict', '--map', str(file), '--pose-deg', '0,0,0,0,0,900')
    assert 'outside the axis range' in str(outside.exception)
    tool = run('predict', '--map', str(file), '--pose-deg', 'P1', '--tool', 'flange')
    assert 'a map of another tool point' in str(tool.exception)


def test_the_report_shows_value_and_sigma_over_two_axes(tmp_path):
    from benchmarks.workspace_map.hidden_arms import hidden_arm, known_arm
    from workspace_map import save_map

    arm = known_arm()
    file, page = tmp_path / 'map.json', tmp_path / 'map.html'
    near = hidden_arm(101).measured(arm.model.pose('P1'))
    save_map(file, WorkspaceMap(arm, 60.0, (near,)), load_layout(ROBOT))
    made = run('report', '--map', str(file), '--out', str(page), '--pose-deg', 'P1')
    assert made.exit_code == 0
    text = page.read_text()
    assert 'mode 1 / Hz' in text
    assert 'σ / %' in text
    assert '1 poses measured' in text
    wrong = run('report', '--map', str(file), '--out', str(page), '--axes', '2,2')
    assert 'not two axes' in str(wrong.exception)


def test_what_is_no_setting_is_refused_before_anything_is_planned(tmp_path):
    common = ['measure', '--out', str(tmp_path / 'map')]
    place = run(*common, '--tool', 'flange:nan,0,0')
    assert 'not three numbers' in str(place.exception)
    arm = run(*common, '--arm', str(tmp_path / 'none.yaml'))
    assert 'cannot be read' in str(arm.exception)
    assert not list(tmp_path.iterdir())
