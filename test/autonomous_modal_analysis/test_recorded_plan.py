"""A recording that holds its plan is analysed below the edge of the plan's excitation."""

import json
import sys

import pytest

from abb_emulator.run_plan import ArmOptions, run_plan
from autonomous_modal_analysis import cli
from autonomous_modal_analysis.campaigns.campaign_plan import (
    CampaignWish,
    DEFAULTS,
    planned_recordings,
)
from autonomous_modal_analysis.campaigns.emulated_player import EmulatedPlayer
from autonomous_modal_analysis.identified.plan_record import recorded_edge_hz
from excitation_planner.request import PlanRequest
from modal_recordings import open_recording
from structural_model import load_layout, load_robot

ROBOT, SENSORS = 'irb6660_205_190', 'sensors_light'
SEED = 4


@pytest.fixture(scope='module')
def recorded(tmp_path_factory):
    """Record one plan of 6 s twice on the emulated arm: with the plan beside it, and without."""
    folder = tmp_path_factory.mktemp('recorded')
    model, layout = load_robot(ROBOT), load_layout(ROBOT, SENSORS)
    request = PlanRequest.from_mapping({**DEFAULTS, 'duration_s': 6.0, 'seed': SEED})
    wish = CampaignWish(poses=[model.pose('P1')], levels=(1.0,), request=request)
    plan = planned_recordings(model, layout, wish)[0].plan(model, layout)
    options = ArmOptions(robot=ROBOT, sensors_file=SENSORS)
    EmulatedPlayer(options).play(plan, folder / 'with.mcap', lambda _: None)
    run_plan(options, plan, folder / 'without.mcap')
    return folder, plan


@pytest.mark.parametrize(
    ('file', 'options', 'high_hz', 'chosen'),
    [
        ('with.mcap', (), 57.0, 'plan'),
        ('with.mcap', ('--max-frequency-hz', '200'), 200.0, 'settings'),
        ('without.mcap', (), None, 'data'),
    ],
)
@pytest.mark.slow
def test_the_band_ends_where_the_plan_says(
    recorded, monkeypatch, capsys, file, options, high_hz, chosen
):
    folder, plan = recorded
    assert plan.band_high_hz == pytest.approx(60.0, abs=0.5)
    command = ['ama', 'identify', str(folder / file), '--window-s', '6', *options, '--json']
    monkeypatch.setattr(sys, 'argv', command)
    with pytest.raises(SystemExit) as ended:
        cli.main()
    said = capsys.readouterr()
    assert not ended.value.code, said.err
    result = json.loads(said.out)
    band = result['band']
    assert band['high_from'] == chosen
    if high_hz is None:
        assert band['high_hz'] > 500.0
    else:
        assert band['high_hz'] == pytest.approx(high_hz, rel=0.01)
    found = [m['frequency_hz'] for w in result['windows'] for m in w['modes']]
    assert found and all(band['low_hz'] <= f <= band['high_hz'] for f in found), f'seed {SEED}'


def test_an_array_has_no_plan(tmp_path):
    (tmp_path / 'a.csv').write_text('1,2\n3,4\n')
    assert recorded_edge_hz(open_recording(tmp_path / 'a.csv', sample_rate_hz=100.0)) is None
