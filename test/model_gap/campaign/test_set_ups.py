"""Sensors that were moved between recordings: each recording with its own layout."""

from copy import copy
from dataclasses import replace

import numpy as np
import pytest
import yaml

from modal_core.errors import SettingsError
from modal_core.files.share import share_path
from model_gap.campaign.read_campaign import read_campaign
from model_gap.campaign.spectra import Band, record_spectra
from model_gap.cell import CellModel
from model_gap.comparison.compare import compare_model
from model_gap.effects.joint_stiffness import JointStiffness
from model_gap.find_gap import find_gap
from model_gap.gap_json import accepted_effects
from model_gap.gravity import rest_of, weigh
from model_gap.predict import Predictor
from model_gap.search.search import SearchSettings
from test.support.hidden_campaign import make_campaign, SENSORS
from test.support.write_campaign import write_campaign

ROBOT = share_path('config', 'robots', 'irb6660_205_190')
FIXED, *MOVED = SENSORS


def written(folder, records, joint_names):
    """Write recordings in two set-ups: sensor ``roving`` of the second stands elsewhere."""
    (_, link, place), (_, other, there) = MOVED[-2:]
    entries, columns = [], {'first': range(3, 6), 'second': range(6, 9)}
    places = {'first': ('roving', link, place), 'second': ('roving', other, there)}
    for number, record in enumerate(records):
        name = ('first', 'second')[number % 2]
        own = record.acceleration[:, [0, 1, 2, *columns[name]]]
        sensors = (FIXED, places[name])
        one = replace(record, acceleration=own)
        write_campaign(folder / name, [one], joint_names, sensors)
        (folder / name / 'sensors.yaml').rename(folder / f'{name}.yaml')
        entry = yaml.safe_load((folder / name / 'campaign.yaml').read_text())['recordings'][0]
        entry['file'] = f'{name}/{entry["file"]}'
        entries.append({**entry, 'layout': f'{name}.yaml'})
    (folder / 'campaign.yaml').write_text(yaml.safe_dump({'recordings': entries}))
    return folder


def recorded(effects, seed, **settings):
    """Return records of the fixed sensor and of both places of the other."""
    return make_campaign(ROBOT, effects, seed, sensors=(FIXED, *MOVED[-2:]), **settings)


@pytest.fixture(scope='module')
def folder(tmp_path_factory, robot):
    records = recorded((), 31, n_fit=2, n_held=1, duration=6.0)
    return written(tmp_path_factory.mktemp('set_ups'), records, robot.joint_names)


def test_a_sensor_that_stands_elsewhere_is_one_more(folder, robot):
    campaign = read_campaign(folder, robot)
    assert [item.name for item in campaign.layout] == ['frame', 'roving', 'roving@second']
    assert [record.missing for record in campaign.records] == [(6, 7, 8), (3, 4, 5)] * 3
    assert 'roving@second.x' in ' '.join(campaign.notes)


def test_what_is_missing_weighs_nothing(folder, robot):
    """χ of all is that of each set-up by itself, by its own number of data."""
    campaign = read_campaign(folder, robot)

    def misfit(records, layout):
        predictor = Predictor(robot, [record_spectra(record, Band()) for record in records])
        rows = predictor.rows(CellModel(robot.spec, layout.channels))
        weighting = predictor.weighting
        return weighting.misfit(rows) * weighting.count, weighting.count

    alone = []
    for number in range(2):
        own = campaign.records[number::2]
        layout = campaign.layout.only(
            {campaign.layout.channels[column].name for column in own[0].recorded}
        )
        whole = [
            replace(record, acceleration=record.acceleration[:, record.recorded], missing=())
            for record in own
        ]
        alone.append(misfit(whole, layout))
    total, count = misfit(campaign.records, campaign.layout)
    assert count == sum(size for _, size in alone)
    assert total == pytest.approx(sum(square for square, _ in alone), rel=1e-5)


def test_a_sensor_of_recordings_left_out_alone_is_left_out_too(tmp_path, robot):
    records = recorded((), 33, n_fit=1, n_held=1, duration=6.0)
    short = [
        replace(r, acceleration=r.acceleration[:900]) if n % 2 else r
        for n, r in enumerate(records)
    ]
    campaign = read_campaign(written(tmp_path, short, robot.joint_names), robot)
    assert [item.name for item in campaign.layout] == ['frame', 'roving']
    assert [record.missing for record in campaign.records] == [(), ()]
    assert 'roving@second' not in ' '.join(campaign.notes)


def test_gravity_of_what_was_not_recorded_is_no_fault(folder, robot):
    campaign = read_campaign(folder, robot)
    settings = SearchSettings()
    assert weigh(rest_of(robot, campaign), settings.tolerances) == ()


@pytest.mark.parametrize(
    ('layout', 'told'), [('nowhere.yaml', 'file missing'), (['frame'], 'not a file')]
)
def test_a_layout_that_is_none_is_one_clear_line(tmp_path, folder, layout, told):
    data = yaml.safe_load((folder / 'campaign.yaml').read_text())
    data['recordings'] = [
        {**entry, 'file': str(folder / entry['file']), 'layout': copy(layout)}
        for entry in data['recordings']
    ]
    (tmp_path / 'campaign.yaml').write_text(yaml.safe_dump(data))
    with pytest.raises(SettingsError, match=told):
        read_campaign(tmp_path, None)


@pytest.mark.slow
def test_an_effect_is_named_with_sensors_that_were_moved(tmp_path, robot):
    hidden = [{'type': 'joint_stiffness', 'joint': 'joint_2', 'factor': 0.8}]
    records = recorded(hidden, 32, n_fit=3, n_held=2, duration=12.0)
    campaign = read_campaign(written(tmp_path, records, robot.joint_names), robot)
    result = find_gap(robot, campaign, SearchSettings(catalogue=(JointStiffness,)))
    (found,) = accepted_effects(result)
    assert found.location.endswith('joint_2'), 'seed 32'
    assert found.parameters[0].value == pytest.approx(0.8, abs=3 * found.parameters[0].sigma)
    assert result.gap_after_heldout < 1.3 * result.noise_floor
    compared = compare_model(result)
    assert {item.sensor for item in compared.sensors} == {'frame', 'roving', 'roving@second'}
    assert all(np.isfinite(item.noise) for item in compared.sensors)
