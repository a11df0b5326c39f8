"""What a map predicts reaches the tracker over real Fast DDS; what cannot be is left out."""

import math
import time

import numpy as np
import pytest

pytest.importorskip('rclpy')
pytest.importorskip('oma_msgs')
pytestmark = pytest.mark.node

from modal_core.errors import MessageError  # noqa: E402
from modal_core.nodes.ros_messages import LATCHED  # noqa: E402
from modal_core.window import Pose  # noqa: E402
from oma_identifier.node.ros_messages import prediction_from  # noqa: E402
from oma_msgs.msg import Mode, PredictedModes  # noqa: E402
from test.support.node_driver import NodeDriver  # noqa: E402


def predicted(position, **changes):
    mode = Mode(id=3, frequency_hz=12.0, frequency_std_hz=0.06, damping_ratio=0.02)
    mode.shape_real, mode.shape_imag = [1.0, -0.5], [0.0, 0.0]
    for name, value in changes.items():
        setattr(mode, name, value)
    return PredictedModes(
        known=True,
        joint_names=['joint_1', 'joint_2'],
        joint_positions=position,
        channel_names=['a.x', 'a.y'],
        modes=[mode],
    )


def test_the_node_gives_the_tracker_what_a_map_predicts(ros_context):
    driver = NodeDriver(ros_context)
    try:
        publisher = driver.peer.create_publisher(
            PredictedModes, 'modal_map/predicted_modes', LATCHED
        )
        # What is no prediction changes nothing, and the node goes on.
        publisher.publish(predicted([0.1, 0.2], frequency_hz=math.nan))
        pose = Pose(('joint_2', 'joint_1'), np.array([0.21, 0.1]), np.zeros(2))
        deadline = time.monotonic() + 60.0
        found = None
        while found is None:
            assert time.monotonic() < deadline, 'nothing came within a minute'
            publisher.publish(predicted([0.1, 0.2]))
            time.sleep(0.05)
            found = driver.node.pipeline.tracker.predictions.at(pose)
        (mode,) = found.modes
        assert (mode.id, mode.frequency_hz, mode.relative_std) == (3, 12.0, 0.005)
        assert list(mode.shape) == [1.0, -0.5]
    finally:
        driver.close()


@pytest.mark.parametrize(
    'changes',
    [
        {'frequency_hz': 0.0},
        {'frequency_std_hz': math.nan},
        {'id': 0},
        {'shape_real': [1.0]},
        {'shape_real': [1.0, math.inf]},
    ],
)
def test_what_is_no_mode_is_refused(changes):
    with pytest.raises(MessageError, match='not a mode'):
        prediction_from(predicted([0.1, 0.2], **changes))


def test_a_pose_that_is_none_is_refused():
    for position in ([0.1], [0.1, math.nan]):
        with pytest.raises(MessageError, match='not a pose'):
            prediction_from(predicted(position))


def test_where_a_map_does_not_know_nothing_is_predicted():
    message = PredictedModes(reason='too far', joint_names=['joint_1'], joint_positions=[0.0])
    assert prediction_from(message).modes == ()
