"""Poses of joints that slide are metres, of those that turn degrees, wherever people see them."""

import numpy as np
import pytest

import autonomous_modal_analysis as ama
from modal_core.errors import ModelError, PlanError
from structural_model import load_robot, save_robot
from structural_model.description import value_words

SLIDE = 'joints: {j: {drive: {stiffness: 1.0e+5}}}'


@pytest.fixture
def gantry(arms):
    """One axis along x, one about y."""
    body = (
        '<link name="base"/>'
        + arms.link('cart', 3.0)
        + arms.link('rod', 2.0, '0 0 0.4', (0.1, 0.1, 0.01))
        + arms.joint('x', 'base', 'cart', axis='1 0 0', kind='prismatic')
        + arms.joint('b', 'cart', 'rod')
    )
    return arms.load(body, 'poses_controller_deg: {there: [0.25, 30.0]}')


def test_a_pose_is_read_in_metres_and_degrees(gantry):
    truth = [0.25, np.pi / 6.0]
    np.testing.assert_allclose(gantry.pose('there'), truth, rtol=1e-12)
    seen = ama.model(gantry, '0.25,30')
    np.testing.assert_allclose(seen.q, truth, rtol=1e-12)
    np.testing.assert_allclose(seen.pose_deg, [0.25, 30.0], rtol=1e-12)
    np.testing.assert_allclose(seen.to_dict()['serial_pose_deg'], [0.25, 30.0], rtol=1e-12)


def test_a_pose_written_is_read_again(gantry, tmp_path):
    save_robot(gantry, tmp_path / 'again')
    again = load_robot(tmp_path / 'again')
    np.testing.assert_allclose(again.pose('there'), gantry.pose('there'), rtol=1e-12)


def test_a_way_out_of_range_is_told_in_metres(gantry):
    with pytest.raises(ModelError, match=r'axis of x \(found 4\.000 m, expected -3\.100 to 3\.1'):
        ama.model(gantry, '4,0')
    with pytest.raises(ModelError, match=r'axis of b \(found 190\.000 deg'):
        ama.model(gantry, '0,190')
    with pytest.raises(ModelError, match=r'2 numbers \[m, deg\]'):
        ama.model(gantry, 'nowhere')


def test_without_a_named_pose_zero_is_shown_and_no_motion_planned(arms):
    model = arms.pendulum(SLIDE)
    np.testing.assert_array_equal(ama.model(model).q, [0.0])
    with pytest.raises(PlanError, match='no start pose') as error:
        ama.plan(model)
    assert '--' not in str(error.value)


def test_where_zero_is_out_of_range_the_nearest_pose_is_taken(arms):
    limits = 'limits: {j: {low_deg: 20.0, high_deg: 90.0}}'
    model = arms.pendulum(f'{SLIDE}\n{limits}')
    np.testing.assert_allclose(ama.model(model).pose_deg, [20.0], rtol=1e-12)


def test_every_axis_is_told_in_its_own_unit(gantry):
    there = gantry.pose('there')
    assert gantry.axes_words(there) == '[0.25 m, 30.0 deg]'
    assert gantry.joints_words(there) == '[0.25 m, 30.0 deg]'
    # A position is told to the millimetre where an angle is told to a tenth of a degree.
    assert list(map(value_words, gantry.shown_axes(there), gantry.sliding)) == ['0.250', '30.0']
