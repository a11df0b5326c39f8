"""Guide with abb_robot_client as its examples do: hear one packet, answer it."""

import importlib
import sys

import numpy as np

# An extra of pip alone: not everywhere installed.
EGM = importlib.import_module('abb_robot_client.egm').EGM
port, most, by_deg = int(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3])
client = EGM(port=port)
heard, asked, goal, planned = 0, 0, None, None
while heard < most:
    success, state = client.receive_from_robot(5.0)
    if not success:
        break
    heard += 1
    assert state.rapid_running and state.motors_on
    assert len(state.joint_angles) == len(state.joint_angles_planned) == 6
    assert len(state.cartesian[0]) == 3 and len(state.cartesian[1]) == 4
    if goal is None:
        goal = state.joint_angles_planned + np.array([0.0, 0.0, 0.0, 0.0, by_deg, 0.0])
    asked += client.send_to_robot(goal)
    planned = state.joint_angles_planned
print(heard, asked, float(np.abs(planned - goal).max()))
