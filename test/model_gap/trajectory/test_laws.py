"""Every law of the catalogue: moves its quantity, says itself, and comes back from its numbers."""

import numpy as np
import pytest

from model_gap.trajectory import read_encoder_campaign
from model_gap.trajectory.catalogue import encoder_offsets, torque_terms, twist_terms
from model_gap.trajectory.gear_told import gear_told
from model_gap.trajectory.known import track_of
from model_gap.trajectory.motion import filter_of, low_passed, motion_of
from model_gap.trajectory.noise import noise_in_band
from model_gap.trajectory.rigid import rigid_of
from model_gap.trajectory.twist_terms import JointStiffness
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


def test_a_gear_with_a_spring_is_told_whole():
    """Model 9.8e5, robot 7e5: what is told is 7e5, not the 2.45e6 that makes it of the model."""
    law = JointStiffness('s2', 1, 1, model_stiffness=9.8e5)
    more = 1.0 / 7e5 - 1.0 / 9.8e5
    effect = law.known(np.array([more]), np.array([[(0.01 * more) ** 2]]))
    (number,) = effect.parameters
    np.testing.assert_allclose(number.value, 7e5, rtol=1e-12)
    np.testing.assert_allclose(number.sigma, 0.01 * more * 7e5**2, rtol=1e-12)
    said = law.sentence({'stiffness': number.value})
    assert (
        said == 'the gear of s2 has a stiffness of 7e+05 N m/rad, 29 % softer than the model says'
    )
    np.testing.assert_allclose(law.weights_of({'stiffness': 7e5}), [more], rtol=1e-12)


def test_a_gear_may_be_stiffer_than_the_model_and_not_than_rigid():
    law = JointStiffness('s2', 1, 1, model_stiffness=4.9e5)
    less = np.array([1.0 / 7e5 - 1.0 / 4.9e5])
    assert law.possible(less, ())
    assert '43 % stiffer than the model says' in law.sentence({'stiffness': 7e5})
    assert not law.possible(np.array([-1.01 / 4.9e5]), ())
    assert not JointStiffness('s2', 1, 1).possible(less, ())


def test_what_carries_no_more_than_noise_is_not_confirmed():
    law = JointStiffness('s2', 1, 1, model_stiffness=5e5)
    load = np.array([-3.0, 3.0])
    well = gear_told(law, 'axis of s2', np.array([0.0]), np.array([[4e-16]]), load)
    np.testing.assert_allclose(well.sigma, 5e5 * 0.01, rtol=1e-12)
    np.testing.assert_allclose(well.within, 0.02, rtol=1e-12)
    assert well.confirmed and well.load_nm == 3.0
    poor = gear_told(law, 'axis of s2', np.array([0.0]), np.array([[1e-12]]), load)
    assert not poor.confirmed
    rigid = gear_told(
        JointStiffness('s2', 1, 1), 'axis of s2', np.array([2e-8]), np.array([[1e-16]]), load
    )
    assert not rigid.confirmed
    np.testing.assert_allclose(rigid.least, 1.0 / 4e-8, rtol=1e-12)


def test_the_noise_left_in_the_band_is_that_of_white_noise_filtered():
    """Beside a slow motion and a line, which are no noise."""
    seed, rate_hz = 31, 250.0
    rng = np.random.default_rng(seed)
    time = np.arange(5000) / rate_hz
    noise = 3.0 * rng.standard_normal((5000, 20))
    slow = 400.0 * np.sin(3.0 * time) + 5.0 * np.sin(2 * np.pi * 80.0 * time)
    found = noise_in_band(noise + slow[:, None], rate_hz, filter_of(rate_hz))
    truth = np.std(low_passed(noise, rate_hz))
    np.testing.assert_allclose(found, truth, rtol=0.12, err_msg=f'seed {seed}')
    np.testing.assert_allclose(found.mean(), truth, rtol=0.03, err_msg=f'seed {seed}')
