"""`ama lobes` on a map: the pose of a cut where the turn about the spindle is free."""

from dataclasses import replace
import json
import math

import pytest
from typer.testing import CliRunner
import yaml

from autonomous_modal_analysis.cli import app
from autonomous_modal_analysis.cut_pose import choose_pose
from benchmarks.workspace_map.hidden_arms import hidden_arm, known_arm, ROBOT
from machining.cut_settings import CutSettings
from machining.lobes import stability_lobes
from modal_core.errors import MapError, SettingsError
from modal_core.tool_modes import ToolModes
from structural_model import load_layout
from workspace_map import save_map, WorkspaceMap

CUT = {
    'n_teeth': 2, 'diameter_mm': 12.0, 'tangential_n_mm2': 3000.0, 'radial_n_mm2': 900.0,
    'min_speed_rpm': 3000.0, 'max_speed_rpm': 6000.0, 'n_speeds': 7, 'n_samples': 8,
    'theory': 'mean', 'max_depth_mm': 100.0, 'spindle_axis': [1.0, 0.0, 0.0],
    'feed_axis': [0.0, 1.0, 0.0],
}  # fmt: skip


@pytest.fixture(scope='module')
def known():
    """Return the map of an arm that was measured at one pose, twice."""
    arm = known_arm()
    near = hidden_arm(101).measured(arm.model.pose('P1'))
    return WorkspaceMap(arm, 60.0, (near,) * 2)


@pytest.fixture(scope='module')
def choice(known):
    settings = CutSettings.from_mapping(CUT)
    return choose_pose(known, known.arm.model.pose('P1'), settings, 20.0)


def by_feed(chart):
    return chart.feed_deg


def test_the_best_pose_takes_most_and_none_takes_more(choice):
    rates = [pose.rate_m_rpm for pose in choice.poses]
    assert choice.best.rate_m_rpm == max(rates) > 0.0
    assert choice.given.turn_deg == 0.0
    assert choice.gain == pytest.approx(choice.best.rate_m_rpm / choice.given.rate_m_rpm)
    assert choice.gain >= 1.0
    assert len(choice.poses) > 1


def test_the_feed_stays_in_the_work_while_the_tool_turns(choice, known):
    """By the modes in the tool's own axes, in which the work turns the other way."""
    settings = CutSettings.from_mapping(CUT)
    for pose in choice.poses:
        if pose.tool is None or pose.proposal is None:
            continue
        modes = known.predict(pose.turned.q)
        angle = pose.turned.turn_rad
        feed = [0.0, math.cos(angle), -math.sin(angle)]
        own = replace(settings, feed_axis=tuple(feed))
        tool = ToolModes(modes.frequency_hz, modes.damping_ratio, modes.tool_shapes.T.copy(), None)
        direct = sorted(stability_lobes(tool, own).charts, key=by_feed)
        alone = replace(pose.tool, covariance=None)
        turned = sorted(stability_lobes(alone, settings).charts, key=by_feed)
        for first, second in zip(direct, turned, strict=True):
            assert first.feed_deg == second.feed_deg
            assert first.mean.depth_m == pytest.approx(second.mean.depth_m, rel=1e-6)


def test_poses_that_the_map_does_not_know_are_none(known):
    settings = CutSettings.from_mapping(CUT)
    with pytest.raises(MapError, match='the map knows no pose of this cut'):
        choose_pose(known, known.arm.model.pose('P3'), settings, 0.0)
    with pytest.raises(SettingsError, match='no turn'):
        choose_pose(known, known.arm.model.pose('P1'), settings, 400.0)


def test_the_command_proposes_a_pose(known, tmp_path):
    file, cut, out = tmp_path / 'map.json', tmp_path / 'cut.yaml', tmp_path / 'out'
    save_map(file, known, load_layout(ROBOT))
    cut.write_text(yaml.safe_dump(CUT))
    common = ['lobes', str(file), '--cut', str(cut)]
    asked = [*common, '--pose-deg', 'P1', '--turn-deg', '10', '--json', '--out', str(out)]
    shown = CliRunner().invoke(app, asked)
    assert shown.exit_code == 0, shown.output
    found = json.loads((out / 'lobes.json').read_text())
    (best,) = [pose for pose in found['poses'] if pose['best']]
    assert len(best['pose_deg']) == 6
    assert best['depth_m'] == pytest.approx(found['proposals'][0]['depth_m'], rel=0.2)
    assert best['speed_rpm'] == found['proposals'][0]['speed_rpm']
    page = (out / 'report.html').read_text()
    assert '(best)' in page
    for extra, said in (
        ((), 'a map knows many poses'),
        (('--turn-deg', '10'), 'a turn from no pose'),
        (('--pose-deg', 'P3'), 'the map knows no pose'),
    ):
        refused = CliRunner().invoke(app, [*common, *extra])
        assert said in str(refused.exception), extra
    tool = tmp_path / 'tool.yaml'
    tool.write_text('modes: [{frequency_hz: 9, damping_ratio: 0.1, shape: [1, 0, 0]}]')
    refused = CliRunner().invoke(app, ['lobes', str(tool), '--cut', str(cut), '--pose-deg', 'P1'])
    assert 'only a map has poses' in str(refused.exception)
