"""Guide with ABBRobotEGM: the newest packet of those that wait, a speed beside the position.

Now and then it names a pose instead of joints, which a session of joints takes for no position,
and sends data and a signal to the program.
"""

import importlib
import sys

import numpy as np

# An extra of pip alone: not everywhere installed.
EGM = importlib.import_module('ABBRobotEGM').EGM
port, most, by_deg = int(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3])
heard, asked, goal, state, number = 0, 0, None, None, -1
with EGM(port=port) as client:
    while heard < most:
        success, state, older = client.receive_latest(5.0)
        if not success:
            break
        heard += 1 + older
        assert state.rapid_running and state.motors_on and state.header.mtype == 2
        assert state.header.seqno > number and state.clock[0] > 0
        number = state.header.seqno
        if goal is None:
            goal = state.joint_angles_planned + np.array([0.0, 0.0, 0.0, 0.0, by_deg, 0.0])
        if heard % 50 == 0:
            place, turn = state.cartesian.pos, state.cartesian.orient
            sent = client.send_to_robot_cart(
                np.array([place.x, place.y, place.z]),
                np.array([turn.u0, turn.u1, turn.u2, turn.u3]),
            )
        else:
            sent = client.send_to_robot(
                goal, speed_ref=np.zeros(6), rapid_to_robot=[heard], digital_signal_to_robot=True
            )
        asked += (1 + older) * sent
print(heard, asked, float(np.abs(state.joint_angles_planned - goal).max()))
