"""Sensitivity and allowed range, against analytic arms and brute force."""

from dataclasses import replace

import numpy as np
import pytest

from excitation_planner.pose_range.allowed_range import allowed_range, largest_change
from excitation_planner.pose_range.mode_following import follow, modes_at
from excitation_planner.pose_range.sensitivity import (
    actual_change,
    added_mass_change,
    expanded_shapes,
    predicted_change,
    sensitivity_table,
    shape_change,
)
from modal_core.errors import PlanError
from structural_model import load_layout, load_robot
from structural_model.description import BaseSpec, Spring

ROBOT = 'irb6660_205_190'
SEED = 11


@pytest.fixture(scope='module')
def robot():
    return load_robot(ROBOT)


def test_added_mass_on_a_spring_is_exact():
    """k = 1, m = 2, a mass 0.5 on top: ω'/ω = sqrt(m / (m + 0.5)), φ² = 1/m."""
    change = added_mass_change(1.0 / np.sqrt(2.0), 0.5)
    assert change == pytest.approx(np.sqrt(2.0 / 2.5) - 1.0, rel=1e-12)
    assert added_mass_change(1.0, 0.5, modal_scale=1.0 / np.sqrt(2.0)) == pytest.approx(change)


def test_no_change_of_pose_no_change_of_frequency(robot):
    q = robot.pose('P1')
    for change in (actual_change(robot, q, 60.0), predicted_change(robot, q, 60.0)):
        assert np.max(np.abs(change(q))) < 1e-9


def test_first_joint_of_an_arm_on_a_rigid_floor_changes_nothing():
    """Turning the arm about the vertical turns everything with it."""
    arm = load_robot('generic_arm_6')
    rigid = arm.replace(
        replace(
            arm.spec,
            base=BaseSpec(),
            joints=(replace(arm.spec.joints[0], tilts=(Spring(), Spring())), *arm.spec.joints[1:]),
        )
    )
    q = rigid.pose(next(iter(rigid.poses_controller_rad)))
    turned = q + 0.4 * np.eye(6)[0]
    assert np.max(np.abs(actual_change(rigid, q, 60.0)(turned))) < 1e-9
    assert np.max(np.abs(predicted_change(rigid, q, 60.0)(turned))) < 1e-9


@pytest.mark.parametrize('pose', ['P1', 'P2', 'P3'])
def test_prediction_from_shapes_has_the_true_slope(robot, pose):
    """To first order Eq. (9) with ΔM is the derivative of an eigenvalue."""
    q = robot.pose(pose)
    table = sensitivity_table(robot, q, 1e-4, 60.0)
    scale = np.max(table.actual)
    separated = np.min(np.abs(np.diff(table.frequency_hz))) > 0.05
    assert separated
    assert table.predicted == pytest.approx(table.actual, abs=0.02 * scale)


def test_modes_are_followed_through_a_crossing(robot):
    q = robot.pose('P2')
    start = modes_at(robot, q, 60.0)
    there = follow(robot, start, q, q + np.deg2rad(15.0))
    back = follow(robot, there, q + np.deg2rad(15.0), q)
    assert back.frequency_hz == pytest.approx(start.frequency_hz, rel=1e-9)


def test_identified_shapes_predict_what_the_model_shapes_do(robot):
    """From the sensors' shapes back to joint coordinates (SEREP), then Eq. (9)."""
    q, channels = robot.pose('P3'), load_layout(ROBOT).channels
    modes = robot.modes(q, channels)
    n_modes = int(np.sum(modes.frequency_hz < 60.0))
    measured = 3.7 * modes.channel_shapes[:, :n_modes].astype(complex)
    expanded = expanded_shapes(robot, q, channels, measured, 60.0)
    other = q + np.deg2rad(3.0)
    change = shape_change(robot, q, modes.frequency_hz[:n_modes], expanded)
    assert change(other) == pytest.approx(predicted_change(robot, q, 60.0)(other), abs=1e-6)


def find(robot, tolerance, weights=None, pose='P1'):
    q = robot.pose(pose)
    change = actual_change(robot, q, 60.0)
    found = allowed_range(
        change,
        q,
        np.ones(6) if weights is None else weights,
        tolerance,
        robot.limits,
        np.random.default_rng(SEED),
    )
    return found, change, q


def test_allowed_range_holds_inside_and_fails_just_outside(robot):
    found, change, q = find(robot, 0.02)
    generator = np.random.default_rng(SEED + 1)
    fresh = found.half_range * generator.uniform(-1.0, 1.0, (300, 6))
    worst = max(np.max(np.abs(change(q + robot.axes.to_serial(x)))) for x in fresh)
    assert worst <= 0.02, f'seed {SEED}: {worst} in 300 poses the proof had not seen'
    assert found.limited_by == 'frequency'
    outside = 1.1 * found.half_range
    beyond = largest_change(
        change,
        q,
        robot.to_controller(q) - outside,
        robot.to_controller(q) + outside,
        robot.limits,
    )
    assert np.max(beyond) > 0.02, 'a box a tenth larger breaks the tolerance at a corner'


def test_allowed_range_grows_with_the_tolerance_and_keeps_the_joint_range(robot):
    small, medium, huge = (find(robot, tolerance)[0] for tolerance in (0.005, 0.02, 1.0))
    assert small.half_range[0] < medium.half_range[0] < huge.half_range[0]
    assert huge.limited_by == 'joint range'
    # At P1 the coupled angle J3 - J2 is 15 deg from its stop, and both axes use it up.
    assert np.rad2deg(huge.half_range[0]) == pytest.approx(7.5, abs=0.01)


def test_resting_joints_stay_and_the_range_is_wider(robot):
    weights = np.array([0.0, 0.0, 0.0, 1.0, 1.0, 1.0])
    wrist = find(robot, 0.02, weights)[0]
    every = find(robot, 0.02)[0]
    assert not wrist.half_range[:3].any()
    assert wrist.half_range[3] > every.half_range[3]


def test_a_tolerance_no_range_meets_is_refused_with_the_numbers(robot):
    with pytest.raises(PlanError) as caught:
        find(robot, 1e-9)
    line = str(caught.value)
    assert '1e-09' in line
    assert '0.001 deg' in line
