"""Every law of the catalogue: moves its quantity, says itself, and comes back from its numbers."""

import numpy as np
import pytest

from model_gap.trajectory import read_encoder_campaign
from model_gap.trajectory.catalogue import encoder_offsets, torque_terms, twist_terms
from model_gap.trajectory.known import track_of
from model_gap.trajectory.motion import motion_of
from model_gap.trajectory.rigid import rigid_of
from structural_model import load_robot
from test.support.encoder_campaign import record, write


@pytest.fixture(scope='module')
def track(tmp_path_factory):
    robot = load_robot('kuka_kr300')
    stiff = {'stiffness': {0: 5e6, 1: 5e6, 2: 5e6}}
    arrays = record(robot, robot.pose('start'), stiff, 41)
    folder = write(tmp_path_factory.mktemp('one'), {'a': arrays})
    campaign = read_encoder_campaign(folder, robot)
    motion = motion_of(campaign.fitting[0], robot, campaign.start)
    return robot, track_of(robot, motion, [])


def every_law(robot, motion):
    rigid = rigid_of(robot)
    return [
        *torque_terms(rigid, [motion]),
        *twist_terms(rigid, motion.encoders, {}),
        *encoder_offsets(rigid, motion.encoders),
    ]


def test_no_law_is_dead_silent_or_one_way(track):
    robot, one = track
    laws = every_law(robot, one.motion)
    assert len({law.type for law in laws}) == 16
    for law in laws:
        columns = law.columns(one)
        assert columns.shape == (one.motion.count, law.rows(one), len(law.weights()))
        assert np.isfinite(columns).all()
        assert (np.abs(columns).max(axis=(0, 1)) > 0.0).all(), law.label
        weights = np.array([0.5 * item.scale for item in law.weights()])
        effect = law.known(weights, np.diag(weights**2))
        numbers = {item.name: item.value for item in effect.parameters}
        assert law.says.format(place='here', **numbers)
        np.testing.assert_allclose(law.weights_of(numbers), weights, rtol=1e-9)
