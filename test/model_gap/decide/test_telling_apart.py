"""What a campaign can tell apart is said before anything is found in it."""

from dataclasses import replace

import numpy as np
import pytest

from model_gap.decide.directions import Directions
from model_gap.decide.telling_apart import NextRecording, Sight, Telling
from model_gap.effects.cable import Cable
from model_gap.effects.joint_stiffness import JointStiffness
from model_gap.effects.sensor_delay import SensorDelay
from model_gap.effects.sensor_gain import SensorGain
from model_gap.effects.sensor_mass import SensorMass
from model_gap.effects.sensor_unit import SensorUnit
from model_gap.effects.stiffness_drift import StiffnessDrift
from model_gap.report import telling_lines
from model_gap.search import SearchSettings
from model_gap.telling import what_it_tells

SEED = 53
FEW = SearchSettings(catalogue=(JointStiffness, SensorMass, StiffnessDrift))


@pytest.fixture(scope='module')
def campaign(campaign_of):
    return campaign_of((), SEED, n_fit=1, n_held=0, duration=6.0)


def test_what_tolerances_or_another_effect_can_do_is_not_told():
    """By hand: four directions of three data, and a tolerance along the third."""
    rows = np.array([[10.0, 0.0, 0.0], [0.0, 10.0, 0.0], [20.0, 0.0, 0.0], [0.0, 0.0, 10.0]])
    tolerance = np.array([[0.0, 0.0, 5.0]])
    places = tuple(slice(number, number + 1) for number in range(4))
    views = Directions(
        places, rows @ rows.T, rows @ tolerance.T, tolerance @ tolerance.T, count=100
    )
    told = views.telling()
    # 300 ln(1 + s/600), s = 600/100 |d|² less what the tolerance takes of it.
    alone = 300.0 * np.log(2.0)
    taken = 600.0 - 6.0**2 * 50.0**2 / (6.0 * 25.0 + 1.0)
    assert told.gain == pytest.approx(
        [alone, alone, 300.0 * np.log(5.0), 300.0 * np.log1p(taken / 600.0)]
    )
    assert told.gain[3] < 3.0
    assert told.apart[0, 2] == pytest.approx(0.0, abs=1e-3) == told.apart[2, 0]
    assert told.apart[0, 1] == pytest.approx(alone) == told.apart[1, 0]


@pytest.mark.slow
def test_a_time_not_waited_for_is_told_by_nothing(campaign, robot):
    """Records that begin at one time show drift of seconds only; later ones tell it apart."""
    later = tuple(
        replace(item, start_s=600.0 * number) for number, item in enumerate(campaign.records)
    )
    drifts = SearchSettings(catalogue=(JointStiffness, StiffnessDrift))
    found = what_it_tells(robot, replace(campaign, records=later), (), drifts)
    assert found.sights and all(np.isfinite(item.gain) for item in found.sights)


@pytest.mark.slow
def test_another_pose_tells_more_and_is_said_as_an_option(campaign, robot):
    pose = campaign.records[0].pose + np.array([0.0, 0.4, -0.5, 0.8, 0.6, 0.3])
    found = what_it_tells(robot, campaign, (pose,), FEW)
    there = next(item for item in found.following if item.pose is not None)
    assert there.seen >= 0
    lines = telling_lines(found, robot)
    assert 'of the catalogue would be seen' in lines[0]
    assert all(line.split(':')[0] for line in lines)


@pytest.mark.slow
def test_an_effect_that_is_begun_from_several_sides_is_one(campaign, robot):
    found = what_it_tells(robot, campaign, (), SearchSettings(catalogue=(Cable,)))
    places = [item.effect.location for item in found.sights]
    assert places and len(set(places)) == len(places)
    for item in found.sights:
        assert item.effect.location not in [other.location for other in item.like]


def test_a_pair_is_told_once_in_one_kind_of_name(robot):
    gain, unit, delay = SensorGain('sensor:a'), SensorUnit('sensor:a'), SensorDelay('sensor:b')
    sights = (
        Sight(gain, (), 99.0, (unit,)),
        Sight(unit, (), 99.0, (gain, delay)),
        Sight(delay, (), 99.0, (unit,)),
    )
    lines = telling_lines(Telling(sights, 8.0, (NextRecording(None, 2.0, 1, 1),)), robot)
    assert lines[2:] == [
        'could not be told apart: sensor gain (sensor:a); sensor unit (sensor:a); '
        'sensor delay (sensor:b)',
    ]
    assert lines[1].endswith(': 1 effect more seen, 1 pair more told apart')


def test_what_to_record_comes_first_and_one_sensor_has_one_line(robot):
    kinds = SensorGain('sensor:a'), SensorUnit('sensor:a'), SensorDelay('sensor:a')
    mass = SensorMass('sensor:b')
    sights = tuple(Sight(effect, (), 99.0, (mass,)) for effect in kinds)
    following = (NextRecording(np.zeros(6), 1.0, 1, 2), NextRecording(None, 2.0, 1, 1))
    lines = telling_lines(Telling(sights, 8.0, following), robot)
    assert [line.split(':')[0] for line in lines[1:3]] == ['next', 'next']
    assert 'within the joint limits' in lines[3]
    (alike,) = lines[4:]
    assert all(name in alike for name in ('gain', 'unit', 'delay')) and 'mass' in alike
