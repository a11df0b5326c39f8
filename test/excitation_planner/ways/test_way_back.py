"""The way back to the start of a plan: short, slow, where the plan goes anyway, or refused."""

import numpy as np
import pytest

from excitation_planner.planner import plan_excitation, plan_limits
from excitation_planner.rapid.rapid import rapid_module
from excitation_planner.request import PlanRequest
from excitation_planner.ways.way_back import is_there, plan_way_back
from modal_core.errors import PlanError
from robot_bridge.player import PlanPath, PlanPlayer, PlayerSettings
from structural_model import load_robot

CYCLE_S = 0.004032


@pytest.fixture(scope='module')
def robot():
    return load_robot('irb6660_205_190')


@pytest.fixture(scope='module')
def request_of(robot):
    return PlanRequest(duration_s=10.0, start_position=tuple(robot.pose('P2')))


@pytest.fixture(scope='module')
def plan(robot, request_of):
    found = plan_excitation(robot, None, request_of)
    assert found.signal == 'sliding_noise'
    return found


def played(robot, plan):
    """Return the positions [deg] of the axes, cycle by cycle, as guidance plays it."""
    path = PlanPath.from_trajectory(plan.plan_hash, plan.trajectory, robot.to_controller)
    player = PlanPlayer(path, path.start_deg, PlayerSettings())
    positions = [path.start_deg]
    while not player.at_rest:
        player.step(CYCLE_S)
        positions.append(player.position_deg)
    return np.array(positions)


def test_from_any_stop_in_a_sweep_the_way_back_is_short_slow_and_within_the_plan(
    robot, request_of, plan
):
    rng = np.random.default_rng(611)
    axes = robot.to_controller(plan.position)
    low, high = np.degrees([axes.min(axis=0), axes.max(axis=0)])
    for sample in rng.integers(500, plan.n_samples - 500, 5):
        # A stop coasts on for a little, and drives leave something.
        here = plan.position[sample] + np.radians(rng.uniform(-0.05, 0.05, 6))
        assert not is_there(here, plan)
        back = plan_way_back(here, plan, plan_limits(robot, request_of))
        assert is_there(back.position[-1], plan) and not is_there(back.position[0], plan)
        way = played(robot, back)
        speed = np.abs(np.diff(way, axis=0)) / CYCLE_S
        assert 0.4 < speed.max() < 0.51, 'seed 611'
        start_deg = np.degrees(robot.to_controller(plan.start_position))
        assert way[-1] == pytest.approx(start_deg, abs=1e-9)
        assert np.all(way > low - 0.2) and np.all(way < high + 0.2)
        # A program of the controller can make it too.
        assert back.plan_hash[:8] in rapid_module(back, robot)


@pytest.mark.parametrize(
    ('away_deg', 'words'),
    [
        ((0.0, 0.0, 0.0, 0.0, 3.2, 0.0), 'axis_5 stands too far from the start'),
        ((0.0, 0.0, 0.0, 2.5, 0.0, 0.0), 'axis_4 stands where the plan does not take it'),
        ((-2.0, 0.0, 0.0, 0.0, 0.0, 0.0), 'axis_1 stands where the plan does not take it'),
    ],
)
def test_an_arm_that_is_far_or_was_moved_since_is_not_led_back(
    robot, request_of, plan, away_deg, words
):
    axes = robot.to_controller(plan.start_position) + np.radians(away_deg)
    with pytest.raises(PlanError, match=f'{words}.*jog'):
        plan_way_back(robot.to_serial(axes), plan, plan_limits(robot, request_of))


def test_a_stopped_approach_goes_back_as_it_came(robot):
    axes = robot.to_controller(robot.pose('P2')) + np.radians([2.0, -1.0, 0.0, 1.5, 0.0, 0.0])
    request = PlanRequest(
        signal='approach',
        approach_from=tuple(robot.to_serial(axes)),
        start_position=tuple(robot.pose('P2')),
    )
    there = plan_excitation(robot, None, request)
    here = there.position[there.n_samples // 2]
    back = plan_way_back(here, there, plan_limits(robot, request))
    part = (back.position - back.position[-1]) @ (here - there.start_position)
    part /= np.sum((here - there.start_position) ** 2)
    straight = back.position[-1] + part[:, None] * (here - there.start_position)
    assert back.position == pytest.approx(straight, abs=1e-9)
    assert back.position[-1] == pytest.approx(there.start_position, abs=1e-9)
