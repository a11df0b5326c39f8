"""What the bridge takes for guidance, the shipped session of the controller follows."""

import numpy as np
import pytest

from abb_emulator.egm import GuidanceLaw, GuidanceSettings
from excitation_planner.planner import plan_excitation
from excitation_planner.request import PlanRequest
from modal_core.files.share import share_path
from modal_core.files.yaml_file import load_yaml
from modal_core.settings.schema import read_values
from robot_bridge.backends.guidance_backend import GuidanceBackend
from robot_bridge.operator import FlowSettings, OperatorFlow
from robot_bridge.player import PlanPath, PlanPlayer, PlayerSettings
from structural_model import load_robot

CYCLE_S, WIRE_CYCLES = 0.004032, 2


@pytest.fixture(scope='module')
def robot():
    return load_robot('irb6660_205_190')


def shipped():
    parameters = load_yaml(share_path('config') / 'emulator.yaml')['/**']['ros__parameters']
    return read_values(GuidanceSettings, parameters['guidance'])


@pytest.mark.parametrize('pose', ['P2', 'P3'])
def test_default_pulses_that_turn_the_wrist_far_are_followed(robot, pose):
    """17 deg at 45 deg/s: a session of 30 deg/s and 5 deg was left behind by 2 deg."""
    start = tuple(robot.pose(pose))
    request = PlanRequest(signal='random_pulses', duration_s=12.0, start_position=start)
    plan = plan_excitation(robot, None, request)
    path = PlanPath.from_trajectory(plan.plan_hash, plan.trajectory, robot.to_controller)
    flow = OperatorFlow(FlowSettings())
    GuidanceBackend('emulator', flow).take(plan, path)
    player = PlanPlayer(path, path.start_deg, PlayerSettings())
    law = GuidanceLaw(GuidanceSettings(**shipped()), path.start_deg, CYCLE_S)
    under_way, apart, way = [], [], []
    while not player.at_rest:
        under_way.append(player.step(CYCLE_S))
        if len(under_way) > WIRE_CYCLES:
            reference = under_way.pop(0)
            law.refer(reference.position_deg, reference.speed_deg_s)
            law.step()
        apart.append(np.abs(law.position_deg - player.position_deg).max())
        way.append(law.position_deg)
    assert np.ptp(way, axis=0).max() > 10.0
    assert max(apart) < 0.5 * flow.settings.max_following_error_deg
