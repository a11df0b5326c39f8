"""A plan as a joint trajectory: its interpolation is the plan, and what band a rate carries."""

import numpy as np
import pytest
from scipy.interpolate import BPoly

from robot_bridge.trajectory import joint_goal, reach


def test_interpolated_by_polynomials_of_degree_five_it_is_the_plan(plan_of_pulses):
    goal = joint_goal(plan_of_pulses)
    plan = plan_of_pulses
    rows = zip(goal.position, goal.velocity, goal.acceleration, strict=True)
    path = BPoly.from_derivatives(goal.time_s, [list(row) for row in rows])
    time_s = np.arange(plan.n_samples) * plan.sample_period_s
    assert np.max(np.abs(path(time_s) - plan.position)) < 3e-6
    assert goal.joint_names == plan.joint_names


def test_it_is_what_a_controller_accepts(plan_of_pulses):
    goal = joint_goal(plan_of_pulses)
    assert goal.time_s[0] == 0.0
    assert not np.any(goal.velocity[0]) and not np.any(goal.acceleration[0])
    assert np.all(np.diff(goal.time_s) > 0.0)
    assert not np.any(goal.velocity[-1]) and not np.any(goal.acceleration[-1])
    assert goal.time_s[-1] == pytest.approx(plan_of_pulses.trajectory.duration_s)


def test_the_band_it_can_reach_is_told(plan_of_pulses):
    plan = plan_of_pulses
    assert 'its band up to' in reach(plan, 20.0 * plan.band_high_hz)
    assert f'to {0.2 * 100.0:.1f} Hz' in reach(plan, 100.0) or plan.band_high_hz < 20.0
    assert 'nothing above' in reach(plan, 4.0 * plan.band_low_hz)
