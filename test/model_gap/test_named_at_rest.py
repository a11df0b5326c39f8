"""What gravity names before the dynamics is a verdict, refined by vibration, and is written."""

import numpy as np
import pytest
import yaml

from model_gap.campaign.read_campaign import read_campaign
from model_gap.decide.decide import Decision, Verdict
from model_gap.effects.encoder_offset import EncoderOffset
from model_gap.effects.joint_stiffness import JointStiffness
from model_gap.effects.sensor_gain import SensorGain
from model_gap.find_gap import find_gap
from model_gap.gap_json import accepted_effects, gap_mapping
from model_gap.gravity import Fault, Kind
from model_gap.named_at_rest import with_faults
from model_gap.report import headline, summary_lines
from model_gap.search.search import Candidate, SearchSettings
from model_gap.updated_model import write_updated_model
from structural_model import load_robot
from test.model_gap.conftest import ROBOT
from test.support.cell_campaign import cell_campaign
from test.support.hidden_campaign import SENSORS
from test.support.write_campaign import write_campaign

SEED = 503
OFFSET = np.radians(2.0)
FEW = SearchSettings(catalogue=(EncoderOffset, JointStiffness, SensorGain), most_effects=1)


def gap_of(robot, folder, *cell):
    records = cell_campaign(ROBOT, SEED, *cell, n_fit=3, n_held=2, duration=12.0)
    write_campaign(folder, records, robot.joint_names, SENSORS)
    return find_gap(robot, read_campaign(folder, robot), FEW)


@pytest.mark.slow
def test_an_encoder_that_is_wrong_is_the_verdict_refined_and_written(robot, tmp_path):
    wrong = {'kind': 'encoder_offset', 'joint': 'joint_2', 'offset': OFFSET}
    result = gap_of(robot, tmp_path / 'campaign', wrong)
    assert result.decision.verdict is Verdict.NAMED, f'seed {SEED}: {result.decision}'
    (effect,) = accepted_effects(result)
    (number,) = effect.parameters
    assert (effect.type, effect.location) == ('encoder_offset', 'joint_2')
    assert abs(number.value - OFFSET) < 3.0 * number.sigma, f'seed {SEED}: {number}'
    (fault,) = result.faults_at_rest
    assert number.sigma < 0.8 * fault.sigma, 'vibration tells more'
    assert result.gap_after_heldout < 0.3 * result.gap_before_heldout
    assert gap_mapping(result)['encoders_told_by_gravity_deg']['joint_1'] is None
    assert any('2.0' in line and 'joint 2' in line for line in summary_lines(result)[:1])
    model = load_robot(write_updated_model(result, tmp_path))
    offsets = [joint.offset_rad for joint in model.spec.joints]
    assert offsets[1] == pytest.approx(number.value, abs=1e-9)
    assert 'offset_rad' in (tmp_path / 'model_updated.diff').read_text()


def test_vibration_tells_a_unit_from_a_zero_offset():
    """Where gravity always pulls along one axis it cannot; put right wrongly, the gain is off."""
    zero = Fault(Kind.ZERO, 'frame.z', (2,), (-8.8,), 0.3, 532.0)
    unit = Fault(Kind.UNIT, 'frame', (0, 1, 2), gain=536.0, rival=zero, telling='turn it')
    alone = with_faults(Decision(Verdict.NONE), [unit], None)
    assert alone.verdict is Verdict.NAMED
    gain = Candidate(SensorGain('sensor:frame'), None, 300.0, 1.0)
    beside = with_faults(Decision(Verdict.NAMED, (gain,)), [unit], None)
    assert beside.verdict is Verdict.AMBIGUOUS
    other = Candidate(SensorGain('sensor:elbow'), None, 300.0, 1.0)
    assert with_faults(Decision(Verdict.NAMED, (other,)), [unit], None).verdict is Verdict.NAMED


@pytest.mark.slow
def test_a_sensor_in_g_is_the_verdict_and_the_corrected_layout_says_so(robot, tmp_path):
    in_g = {'kind': 'sensor', 'turned': {'elbow': np.eye(3) / 9.80665}}
    result = gap_of(robot, tmp_path / 'campaign', in_g)
    assert result.decision.verdict is Verdict.NAMED, f'seed {SEED}: {result.decision}'
    (effect,) = accepted_effects(result)
    assert (effect.type, effect.location) == ('sensor_unit', 'sensor:elbow')
    assert 'reads in g' in headline(result)
    write_updated_model(result, tmp_path)
    sensors = yaml.safe_load((tmp_path / 'sensors.yaml').read_text())['sensors']
    assert [item['name'] for item in sensors if item.get('unit') == 'g'] == ['elbow']
