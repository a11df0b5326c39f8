"""Places that a campaign does not tell apart are said, all of them."""

import pytest

from model_gap.campaign.read_campaign import read_campaign
from model_gap.decide import Verdict
from model_gap.effects.joint_stiffness import JointStiffness
from model_gap.effects.payload import Payload
from model_gap.find_gap import find_gap
from model_gap.gap_json import found_effects
from model_gap.report.words import effect_words, headline
from model_gap.search import SearchSettings
from structural_model import save_robot
from test.support.hidden_campaign import make_campaign, SENSORS
from test.support.write_campaign import write_campaign

SEED = 797049


@pytest.fixture(scope='module')
def found(robot, tmp_path_factory):
    """A mass on the flange of an arm whose last joint hardly twists."""
    names = [name for name in robot.parameters() if name.startswith('joints.joint_6.')]
    stiff = {n: 1e3 * robot.parameters()[n] for n in names if n.endswith('stiffness')}
    model = robot.with_parameters(stiff)
    folder = tmp_path_factory.mktemp('stiff')
    save_robot(model, folder / 'robot')
    hidden = [{'type': 'payload', 'link': 'flange', 'mass': 20.0, 'com': (0.0, 0.0, 0.0)}]
    size = {'n_fit': 3, 'n_held': 2, 'duration': 8.0}
    records = make_campaign(folder / 'robot', hidden, SEED, **size)
    write_campaign(folder, records, model.joint_names, SENSORS)
    few = SearchSettings(catalogue=(Payload, JointStiffness))
    return find_gap(model, read_campaign(folder, model), few)


@pytest.mark.slow
def test_two_links_with_a_stiff_joint_between_are_both_said(found):
    assert found.decision.verdict is Verdict.AMBIGUOUS, f'seed {SEED}'
    (effect,) = found_effects(found)
    places = {effect['location'], *(item['location'] for item in effect['other_places'])}
    assert places == {'link_5', 'flange'}, f'seed {SEED}'
    assert effect['parameters']['mass']['value'] == pytest.approx(20.0, rel=0.1), f'seed {SEED}'
    said = headline(found)
    assert ' or ' in said and 'Perhaps' not in said and 'do not tell' in said
    (line,) = effect_words(found)
    assert all(f'at {place}: mass' in line for place in places)
    assert found.decision.experiments
    assert all(place in item for place in places for item in found.decision.experiments)
