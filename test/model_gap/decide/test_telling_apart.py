"""What a campaign can tell apart is said before anything is found in it."""

from dataclasses import replace

import numpy as np
import pytest

from modal_core.channel import SensorLayout
from model_gap.effects.joint_stiffness import JointStiffness
from model_gap.effects.sensor_mass import SensorMass
from model_gap.effects.stiffness_drift import StiffnessDrift
from model_gap.report import telling_lines
from model_gap.search import SearchSettings
from model_gap.telling import what_it_tells

pytestmark = pytest.mark.slow
SEED = 53
FEW = SearchSettings(catalogue=(JointStiffness, SensorMass, StiffnessDrift))


@pytest.fixture(scope='module')
def campaign(campaign_of):
    return campaign_of((), SEED, n_fit=1, n_held=0, duration=6.0)


def test_many_sensors_see_what_one_does_not(campaign, robot):
    every = what_it_tells(robot, campaign, (), FEW)
    first = slice(0, 3)  # one IMU, on the frame
    one = replace(
        campaign,
        layout=SensorLayout((campaign.layout.sensors[0],)),
        records=tuple(
            replace(item, acceleration=item.acceleration[:, first]) for item in campaign.records
        ),
    )
    less = what_it_tells(robot, one, (), FEW)
    assert len(every.unseen) < len(less.unseen) < len(less.sights), f'seed {SEED}'


def test_a_time_not_waited_for_is_told_by_nothing(campaign, robot):
    """Records that begin at one time show drift of seconds only; later ones tell it apart."""
    later = tuple(
        replace(item, start_s=600.0 * number) for number, item in enumerate(campaign.records)
    )
    drifts = SearchSettings(catalogue=(JointStiffness, StiffnessDrift))
    found = what_it_tells(robot, replace(campaign, records=later), (), drifts)
    assert found.sights and all(np.isfinite(item.gain) for item in found.sights)


def test_another_pose_tells_more_and_is_said_as_an_option(campaign, robot):
    pose = campaign.records[0].pose + np.array([0.0, 0.4, -0.5, 0.8, 0.6, 0.3])
    found = what_it_tells(robot, campaign, (pose,), FEW)
    there = next(item for item in found.following if item.pose is not None)
    assert there.seen >= 0
    lines = telling_lines(found, robot)
    assert 'of the catalogue would be seen' in lines[0]
    assert all(line.split(':')[0] for line in lines)
