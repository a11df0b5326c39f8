"""How roughly a model is known: by kind or by name, in the model, the campaign or options."""

import dataclasses

import numpy as np
import pytest
import yaml

from modal_core.errors import ModelError, SettingsError
from model_gap.campaign.campaign_file import read_campaign_file
from model_gap.campaign.explicit_damping import explicit_damping
from model_gap.campaign.spectra import Band, record_spectra
from model_gap.cell.cell_model import CellModel
from model_gap.cell.tolerances import nuisances, Tolerances
from model_gap.predict.predict import Predictor
from model_gap.search.search import links_with_mass
from model_gap.stated import stated_settings
from structural_model import load_robot, save_robot


@pytest.fixture(scope='module')
def campaign(campaign_of):
    return campaign_of((), 3, n_fit=1, n_held=0, duration=6.0, levels=(1.0,))


@pytest.fixture
def cell(robot, layout):
    return CellModel(explicit_damping(robot.spec), layout.channels)


def sizes(cell, robot, tolerances):
    return {it.name: it.sigma for it in nuisances(cell, links_with_mass(robot), tolerances)}


def test_what_is_stated_later_counts_and_a_name_counts_before_its_kind(robot, cell, campaign):
    model = dataclasses.replace(
        robot,
        spec=dataclasses.replace(robot.spec, tolerances=(('stiffness', 0.3), ('mass', 0.05))),
    )
    said = dataclasses.replace(campaign, tolerances={'stiffness': 0.4})
    stated = {'stiffness of joint_2': '0.1', 'sensor_rotation_deg': 3}
    found = sizes(cell, robot, stated_settings(model, said, tolerances=stated).tolerances)
    assert found['stiffness of joint_1'] == 0.4
    assert found['stiffness of joint_2'] == 0.1
    assert found['mass of link_3'] == 0.05
    assert found['rotation of elbow (x)'] == pytest.approx(np.radians(3.0))


def test_no_damping_is_known_better_than_its_spring_unless_it_is_stated(cell, robot):
    stated = {'stiffness': 0.4, 'damping of joint_3': 0.05, 'stiffness of joint_2': 0.0}
    found = sizes(cell, robot, Tolerances().stated(stated, ''))
    assert found['damping of joint_1'] == 0.4
    assert found['damping of joint_2'] == Tolerances().damping
    assert found['damping of joint_3'] == 0.05
    assert found['damping across joint_2 (1)'] == 0.4
    assert sizes(cell, robot, Tolerances())['damping of joint_1'] == Tolerances().damping


def test_what_has_no_tolerance_is_known_exactly(cell, robot):
    found = sizes(cell, robot, Tolerances().stated({'mass': 0, 'mass of link_3': 0.1}, ''))
    assert [name for name in found if name.startswith('mass of')] == ['mass of link_3']


@pytest.mark.parametrize(
    ('stated', 'said'),
    [
        ({'stiffness': -0.1}, '0 to 1'),
        ({'stiffness': 'soft'}, 'not a tolerance'),
        ({'stiffness': True}, 'not a tolerance'),
        ({'stiffness': float('nan')}, 'not a tolerance'),
        ({'sensor_rotation_deg': 90}, '0 to 30 deg'),
        ({'stifness': 0.1}, 'stiffness'),
        ({'stiffness of joint_9': 0.1}, 'stiffness of joint_'),
    ],
)
def test_what_is_no_tolerance_is_one_line(stated, said, cell, robot):
    with pytest.raises(SettingsError) as caught:
        sizes(cell, robot, Tolerances().stated(stated, 'here'))
    assert said in str(caught.value) and '\n' not in str(caught.value)


def test_the_model_file_keeps_them(robot, tmp_path):
    spec = dataclasses.replace(robot.spec, tolerances=(('stiffness', 0.4),))
    save_robot(robot.replace(spec), tmp_path)
    assert load_robot(tmp_path).spec.tolerances == (('stiffness', 0.4),)
    data = yaml.safe_load((tmp_path / 'model.yaml').read_text())
    (tmp_path / 'model.yaml').write_text(yaml.safe_dump({**data, 'tolerances': {'mass': [1]}}))
    with pytest.raises(ModelError, match='tolerances: mass'):
        load_robot(tmp_path)


def test_the_campaign_file_states_them(tmp_path):
    (tmp_path / 'a.mcap').touch()
    content = {'recordings': ['a.mcap'], 'tolerances': {'stiffness': 0.4}}
    (tmp_path / 'campaign.yaml').write_text(yaml.safe_dump(content))
    assert read_campaign_file(tmp_path).tolerances == {'stiffness': 0.4}
    (tmp_path / 'campaign.yaml').write_text(yaml.safe_dump({**content, 'tolerances': 0.4}))
    with pytest.raises(SettingsError, match='tolerances'):
        read_campaign_file(tmp_path)


def test_every_tolerance_moves_the_prediction(robot, cell, campaign):
    """By ten sigma: what moves nothing is no tolerance."""
    records = [record_spectra(item, Band(), 60) for item in campaign.records]
    predictor = Predictor(robot, records)
    (base,) = predictor.predict(cell)
    for item in nuisances(cell, links_with_mass(robot), Tolerances()):
        (there,) = predictor.predict(item.apply(cell, 3.0))
        assert np.abs(there - base).max() > 1e-6 * np.abs(base).max(), item.name


def test_a_tool_is_known_no_better_than_a_link(cell, robot):
    """A 52 kg spindle 3 mm off looks like play of the last joint, where it may not be."""
    found = sizes(cell, robot, Tolerances())
    (tool,) = cell.spec.masses
    for what in ('mass of {}', 'inertia of {}', *(f'centre of mass of {{}} ({x})' for x in 'xyz')):
        assert found[what.format(tool.name)] == found[what.format('link_6')], what


def test_a_sensor_of_one_axis_turns_about_the_others_only(robot, cell):
    one = tuple(item for item in cell.channels if item.name != 'elbow.x')[:7]
    names = sizes(dataclasses.replace(cell, channels=one), robot, Tolerances())
    turned = [name for name in names if name.startswith('rotation of elbow')]
    assert turned == ['rotation of elbow (x)', 'rotation of elbow (z)']
