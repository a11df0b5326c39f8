"""Poses with the tool turned about a spindle, by pinocchio's own kinematics of the URDF."""

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from benchmarks.workspace_map.hidden_arms import known_arm, ROBOT, TOOL
from modal_core.errors import ModelError
from workspace_map import turned_poses

URDF = Path(__file__).resolve().parents[2] / 'config' / 'robots' / ROBOT / 'robot.urdf'


def place(q):
    """Return where the tool point is [m], and the rotation of the tool."""
    model = pin.buildModelFromUrdf(str(URDF))
    data = model.createData()
    pin.forwardKinematics(model, data, q)
    pin.updateFramePlacements(model, data)
    frame = data.oMf[model.getFrameId(TOOL.link)]
    return frame.act(np.array(TOOL.position_m)), frame.rotation


@pytest.mark.parametrize('axis', [(0.0, 0.0, 2.0), (1.0, 0.0, 0.0), (0.3, -0.5, 1.0)])
def test_the_tool_point_rests_and_the_tool_turns_about_the_axis(axis):
    arm = known_arm()
    start = arm.model.pose('P1') + np.deg2rad([0.0, 0.0, 0.0, 20.0, 15.0, 0.0])
    point, rotation = place(start)
    found = turned_poses(arm, start, axis, np.deg2rad(40.0), np.deg2rad(10.0))
    assert len(found) > 2
    along = np.array(axis) / np.linalg.norm(axis)
    for pose in found:
        there, turned = place(pose.q)
        assert there == pytest.approx(point, abs=1e-6)
        relative = rotation.T @ turned
        assert relative == pytest.approx(pose.axes, abs=1e-6)
        assert pin.log3(relative) == pytest.approx(pose.turn_rad * along, abs=1e-6)
        arm.model.check_pose(pose.q)


def test_a_turn_ends_where_a_joint_does():
    arm = known_arm()
    start = arm.model.pose('P1')
    found = turned_poses(arm, start, (1.0, 0.0, 0.0), np.deg2rad(180.0), np.deg2rad(20.0))
    turns = np.rad2deg([pose.turn_rad for pose in found])
    assert 0.0 in turns and list(turns) == sorted(turns)
    assert len(turned_poses(arm, start, (1.0, 0.0, 0.0), 0.0, 0.1)) == 1
    with pytest.raises(ModelError):
        turned_poses(arm, np.full(6, 9.0), (1.0, 0.0, 0.0), 0.0, 0.1)
