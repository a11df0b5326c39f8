"""From recordings to a verdict: hidden effects are found, healthy arms are left alone."""

import json
import re

import numpy as np
import pytest

from model_gap.comparison import compare_model
from model_gap.decide.decide import too_little, Verdict
from model_gap.effects.joint_damping import JointDamping
from model_gap.effects.joint_stiffness import JointStiffness
from model_gap.effects.payload import Payload
from model_gap.effects.sensor_delay import SensorDelay
from model_gap.effects.sensor_gain import SensorGain
from model_gap.find_gap import find_gap
from model_gap.gap_json import write_gap_json
from model_gap.report.page import write_report
from model_gap.result_folder import ResultFolder
from model_gap.search.search import Search, SearchSettings
from model_gap.updated_model import write_updated_model
from structural_model import load_layout, load_robot
from test.support import browser
from test.support.hidden_campaign import SENSORS

SEED = 21
FEW = SearchSettings(
    catalogue=(JointStiffness, JointDamping, Payload, SensorGain, SensorDelay), most_effects=2
)
FEWEST = SearchSettings(catalogue=(JointStiffness, SensorGain), most_effects=1)
# What programs may rely on: name and kind of every fixed key.
SCHEMA = {
    'verdict': str, 'effects': list, 'candidates': list, 'where': list, 'gap_before': float,
    'gap_after': float, 'gap_before_heldout': float, 'gap_after_heldout': float,
    'noise_floor': float,
}  # fmt: skip


@pytest.fixture(scope='module')
def softer(campaign_of, robot):
    hidden = [{'type': 'joint_stiffness', 'joint': 'joint_2', 'factor': 0.7}]
    return find_gap(robot, campaign_of(hidden, SEED), FEW)


@pytest.mark.slow
def test_softer_joint_is_named_with_its_value(softer):
    assert softer.decision.verdict is Verdict.NAMED, f'seed {SEED}: {softer.decision}'
    best = softer.decision.accepted[-1]
    assert [effect.key for effect in best.fit.hypothesis.effects] == [
        ('joint_stiffness', 'joint_2')
    ]
    (values,) = best.fit.hypothesis.values()
    sigma = float(np.sqrt(best.fit.covariance[0, 0])) * values[0]
    assert abs(values[0] - 0.7) < 3.0 * sigma, f'seed {SEED}: {values[0]} ± {sigma}'
    assert 0.005 < sigma < 0.03, 'the spring has a tolerance of its own'


@pytest.mark.slow
def test_gap_shrinks_to_the_noise_on_poses_that_took_no_part(softer):
    assert softer.gap_before_heldout > 5.0 * softer.noise_floor
    assert softer.gap_after_heldout < 1.5 * softer.noise_floor


@pytest.fixture(scope='module')
def compared(softer):
    return compare_model(softer)


@pytest.mark.slow
def test_gap_json_has_its_fixed_keys(softer, compared, tmp_path):
    write_gap_json(softer, tmp_path / 'gap.json', compared)
    found = json.loads((tmp_path / 'gap.json').read_text())
    for key, kind in SCHEMA.items():
        assert isinstance(found[key], kind), key
    for effect in (*found['effects'], *found['candidates']):
        assert isinstance(effect['type'], str)
        place = effect['location']
        assert place is None or re.fullmatch(
            r'joint_\d|link_\d|flange|base_link|sensor:\w+', place
        )
        for number in effect['parameters'].values():
            assert set(number) == {'value', 'sigma', 'unit'}
            assert isinstance(number['value'], float)
    gains = [item['log_evidence_gain'] for item in found['candidates'] if item['round'] == 1]
    assert gains == sorted(gains, reverse=True)
    for table in ('modes', 'sensors', 'amplitude_dependence', 'excitation'):
        assert found['comparison'][table], table


@pytest.mark.slow
def test_comparison_sees_the_gap_and_its_end(softer, compared):
    before = [pair.deviations(pair.before) for pair in compared.modes]
    after = np.array([pair.deviations(pair.after) for pair in compared.modes if pair.after])
    assert np.nanmax(np.abs(before)) > 4.0, f'seed {SEED}'
    assert len(after) >= 0.8 * len(compared.modes)
    assert np.sqrt(np.mean(after**2)) < 2.5, f'seed {SEED}: {after}'
    mac = [pair.after.mac for pair in compared.modes if pair.after and pair.mode.mpc > 0.95]
    assert np.median(mac) > 0.95, f'seed {SEED}: {mac}'
    loud = [row for row in compared.sensors if row.measured > 20.0 * row.noise]
    assert loud
    for row in loud:
        assert abs(row.after.magnitude - 1.0) < 0.05, row
        assert row.after.coherence > 0.99
    worst = max(loud, key=lambda row: abs(row.before.phase_rad))
    assert abs(worst.before.phase_rad) > 5.0 * worst.before.phase_sigma_rad
    for change in compared.levels:
        assert change.deviations < 5.0, f'the arm is linear, seed {SEED}: {change}'


@pytest.mark.slow
def test_result_files(softer, compared, tmp_path):
    write_gap_json(softer, tmp_path / 'gap.json', compared)
    found = json.loads((tmp_path / 'gap.json').read_text())
    assert found['verdict'] == 'named'
    (effect,) = found['effects']
    assert effect['type'] == 'joint_stiffness'
    assert effect['location'] == 'joint_2'
    assert set(effect['parameters']['factor']) == {'value', 'sigma', 'unit'}
    path = write_updated_model(softer, tmp_path)
    model = load_robot(path)
    old = softer.search.model.spec.joints[1].drive.spring.stiffness
    new = model.spec.joints[1].drive.spring.stiffness
    assert new / old == pytest.approx(effect['parameters']['factor']['value'], rel=1e-6)
    (known,) = model.spec.effects
    assert (known.type, known.location, known.kept_in) == ('joint_stiffness', 'joint_2', 'model')
    assert 'stiffness' in (tmp_path / 'model_updated.diff').read_text()
    assert load_layout(path).channels == softer.search.campaign.layout.channels
    write_report(softer, tmp_path / 'report.html', compared)
    page = (tmp_path / 'report.html').read_text()
    softer_by = 100.0 * (1.0 - effect['parameters']['factor']['value'])
    assert f'Joint 2 is {softer_by:.0f} % softer than the model says' in page
    assert 'joint stiffness at joint_2' in page
    assert '<script' not in page
    assert 'http://' not in page
    assert 'https://' not in page
    assert "'unsafe-inline'" not in page


@pytest.mark.slow
@pytest.mark.skipif(browser.find_browser() is None, reason='no Chromium')
def test_report_in_a_browser(softer, compared, tmp_path):
    path = tmp_path / 'report.html'
    write_report(softer, path, compared)
    with browser.browser_page() as page:
        for width, dark in ((1280, False), (420, True)):
            page.open(path, width=width, dark=dark)
            assert page.evaluate('document.documentElement.scrollWidth') <= width
        headings = page.evaluate("[...document.querySelectorAll('h2')].map(h => h.textContent)")
        rows = page.evaluate(
            "[...document.querySelectorAll('table')].map(t => t.tBodies[0].rows.length)"
        )
        curves = page.evaluate("document.querySelectorAll('.hero polyline').length")
        cells = page.evaluate("document.querySelectorAll('.map rect').length")
        assert page.problems == []
        assert page.requests == [path.resolve().as_uri()] * 2
    assert headings[-1] == 'Provenance' and 'Compared' in headings
    assert min(rows) >= 1 and curves == 3
    assert cells == 2 * len(SENSORS) * len({(row.low_hz, row.high_hz) for row in compared.sensors})


@pytest.mark.slow
def test_what_was_found_is_kept_before_it_is_compared(softer, compared, tmp_path):
    folder = ResultFolder(tmp_path / 'new' / 'out')
    folder.prepare()
    (folder.path / 'report.html').write_text('of an older search')
    folder.write_found(softer)
    found = json.loads((folder.path / 'gap.json').read_text())
    assert found['verdict'] == 'named' and found['comparison'] is None
    assert load_robot(folder.path / 'model_updated.yaml').spec.effects
    assert not (folder.path / 'report.html').exists(), 'the older report says something else'
    folder.write_compared(softer, compared)
    assert json.loads((folder.path / 'gap.json').read_text())['comparison']['modes']
    assert 'Joint 2 is' in (folder.path / 'report.html').read_text()


def test_healthy_arm_has_no_gap(campaign_of, robot):
    result = find_gap(robot, campaign_of((), SEED + 1), FEW)
    assert result.decision.verdict is Verdict.NONE, f'seed {SEED + 1}: {result.decision}'
    assert result.gap_after_heldout < 1.3 * result.noise_floor


def test_stranger_is_not_named(campaign_of, robot):
    hidden = [{'type': 'end_stop', 'joint': 'joint_2', 'gap': 1e-4, 'k': 8e6}]
    campaign = campaign_of(hidden, SEED + 2, n_fit=2, n_held=1)
    result = find_gap(robot, campaign, FEWEST)
    assert result.decision.verdict is Verdict.UNEXPLAINED, f'seed {SEED + 2}: {result.decision}'


def test_one_pose_is_too_little_for_a_name(campaign_of, robot):
    hidden = [{'type': 'joint_stiffness', 'joint': 'joint_2', 'factor': 0.7}]
    campaign = campaign_of(hidden, SEED + 3, n_fit=1, n_held=0)
    result = find_gap(robot, campaign, FEWEST)
    assert result.decision.verdict is not Verdict.NAMED
    assert any('pose' in text for text in result.decision.reasons), result.decision.reasons


def test_one_level_is_too_little_for_a_name(campaign_of, robot):
    campaign = campaign_of((), SEED + 4, n_fit=2, n_held=1, duration=6.0, levels=(1.0,))
    (lack,) = too_little(Search.begin(robot, campaign, FEWEST))
    assert 'only one amplitude level' in lack
