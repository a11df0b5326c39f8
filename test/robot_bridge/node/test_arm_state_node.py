"""What viewers of the arm are told: description, frames, and that frames follow the joints."""

import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

pytest.importorskip('rclpy')
pytest.importorskip('oma_msgs')
pytestmark = pytest.mark.node


@pytest.fixture
def arm_state(drivers, domain):
    """Run the node in a process of its own."""
    process = subprocess.Popen(
        [sys.executable, '-m', 'robot_bridge.node.arm_state_node'],
        env={**os.environ, 'ROS_DOMAIN_ID': str(domain)},
        stderr=subprocess.PIPE,
        text=True,
    )
    yield process
    process.terminate()
    process.communicate()
    # A node that is still starting ends as the system ends it.
    assert process.returncode in (0, -signal.SIGTERM)


def test_the_description_is_there_for_those_who_come_late(arm_state, operator, drivers, model):
    from std_msgs.msg import String

    time.sleep(1.0)
    heard = []
    operator.node.create_subscription(String, '/robot_description', heard.append, drivers.LATCHED)
    operator.until(lambda: heard, 'description')
    assert f'<robot name="{model.robot_name}"' in heard[0].data


@pytest.mark.smoke
def test_frames_follow_the_joints(arm_state, operator, drivers, model):
    messages = pytest.importorskip('tf2_msgs.msg')
    from sensor_msgs.msg import JointState

    fixed, moving = [], []
    create = operator.node.create_subscription
    create(messages.TFMessage, '/tf_static', fixed.append, drivers.LATCHED)
    create(messages.TFMessage, '/tf', moving.append, 100)
    publisher = operator.node.create_publisher(JointState, '/joint_states', 10)
    for angle in (0.0, 0.5):
        q = model.pose('P1') + np.array([angle, 0.0, 0.0, 0.0, 0.0, 0.0])
        # Another order, and one more joint than the arm has.
        state = JointState(name=['gripper', *reversed(model.joint_names)])
        state.position = [0.1, *reversed(q.tolist())]
        state.header.stamp.sec = 7
        del moving[:]

        def told(state=state):
            publisher.publish(state)
            return len(moving) > 3

        operator.until(told, 'frames', pause_s=0.05)
        transforms = {each.child_frame_id: each for each in moving[-1].transforms}
        assert {'link_1', 'link_6'} <= set(transforms)
        assert transforms['link_1'].header.stamp.sec == 7
        turn = transforms['link_1'].transform.rotation
        assert 2.0 * np.arctan2(turn.z, turn.w) == pytest.approx(q[0], abs=1e-6)
    operator.until(lambda: fixed, 'fixed frames')
    assert {each.child_frame_id for each in fixed[0].transforms} == {'flange'}


def test_joint_states_that_cannot_be_read_end_nothing(arm_state, operator, drivers, model):
    messages = pytest.importorskip('tf2_msgs.msg')
    from rclpy.serialization import serialize_message
    from sensor_msgs.msg import JointState

    moving = []
    operator.node.create_subscription(messages.TFMessage, '/tf', moving.append, 100)
    publisher = operator.node.create_publisher(JointState, '/joint_states', 10)
    state = JointState(name=list(model.joint_names), position=model.pose('P1').tolist())

    def told():
        publisher.publish(state)
        return len(moving) > 3

    operator.until(told, 'frames', pause_s=0.05)
    for bad in (serialize_message(state)[:20], serialize_message(state)[:4] + b'\xff' * 40):
        for _ in range(5):
            publisher.publish(bad)
            time.sleep(0.05)
    del moving[:]
    operator.until(told, 'frames', pause_s=0.05)
    assert arm_state.poll() is None
