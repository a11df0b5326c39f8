import numpy as np
import pytest

from modal_core.channel import Sensor, SensorLayout
from modal_core.files.share import share_path
from model_gap.campaign.read_campaign import read_campaign
from structural_model import load_robot
from test.support.hidden_campaign import make_campaign, SENSORS
from test.support.write_campaign import write_campaign

ROBOT = share_path('config', 'robots', 'irb6660_205_190')


@pytest.fixture(scope='session')
def robot():
    return load_robot(ROBOT)


@pytest.fixture(scope='session')
def layout():
    return SensorLayout(tuple(Sensor(name, link, place) for name, link, place in SENSORS))


@pytest.fixture(scope='session')
def campaign_of(robot, tmp_path_factory):
    """Make, write and read a campaign with effects hidden in it."""

    def make(effects=(), seed=0, **options):
        folder = tmp_path_factory.mktemp('campaign')
        settings = {'n_fit': 3, 'n_held': 2, 'duration': 12.0, **options}
        records = make_campaign(ROBOT, effects, seed, **settings)
        write_campaign(folder, records, robot.joint_names, SENSORS)
        return read_campaign(folder, robot)

    return make


@pytest.fixture
def rng():
    return np.random.default_rng(5)
