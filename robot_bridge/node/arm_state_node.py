"""Tells viewers of the arm: its description, and where its links stand now.

What ``robot_state_publisher`` does, also where there is none.
"""

from collections.abc import Iterable, Sequence
from typing import Any

from geometry_msgs.msg import TransformStamped
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_msgs.msg import String

from modal_core.nodes.newest_joints_node import NewestJoints
from modal_core.nodes.ros_messages import declare_parameters, LATCHED
from modal_core.nodes.run_node import run_node
from robot_bridge.node.arm_state_parameters import PARAMETERS
from structural_model.rigid import FrameTree, LinkPlace
from structural_model.robot_files import load_robot

try:
    from tf2_msgs.msg import TFMessage
except ImportError:
    # Not among the wheels of PyPI: ./tf2_msgs of the source tree builds it.
    TFMessage = None

FRAMES = QoSProfile(depth=100, reliability=ReliabilityPolicy.RELIABLE)


class ArmStateNode(Node):
    """Publishes ``robot_description``, ``tf`` and ``tf_static`` of the cell's namespace."""

    def __init__(self, **options: Any) -> None:
        super().__init__('arm_state', **options)
        declare_parameters(self, PARAMETERS)
        model = load_robot(self.get_parameter('robot').value)
        self._tree = FrameTree(model.robot)
        self._description = self.create_publisher(String, 'robot_description', LATCHED)
        self._description.publish(String(data=model.robot.text.decode()))
        if TFMessage is None:
            self.get_logger().warning(
                'no frames are published: tf2_msgs is not installed; in the source tree:'
                ' pip install ./tf2_msgs'
            )
            return
        self._frames = self.create_publisher(TFMessage, 'tf', FRAMES)
        self._fixed = self.create_publisher(TFMessage, 'tf_static', LATCHED)
        now = self.get_clock().now().to_msg()
        self._fixed.publish(TFMessage(transforms=_transforms(self._tree.fixed(), now)))
        # Joint states come eight times as often as anybody looks: the newest is enough.
        topic = self.get_parameter('joint_states_topic').value
        self._joints = NewestJoints(self, topic, model.joint_names)
        self.create_timer(1.0 / self.get_parameter('rate_hz').value, self._publish)

    def _publish(self) -> None:
        pose = self._joints.take()
        if pose is not None:
            transforms = _transforms(self._tree.moving(pose.position), pose.stamp)
            self._frames.publish(TFMessage(transforms=transforms))


def _transforms(places: Iterable[LinkPlace], stamp: Any) -> list[TransformStamped]:
    found = []
    for place in places:
        message = TransformStamped(child_frame_id=place.child)
        message.header.frame_id, message.header.stamp = place.parent, stamp
        there, turn = message.transform.translation, message.transform.rotation
        there.x, there.y, there.z = place.position.tolist()
        turn.x, turn.y, turn.z, turn.w = place.quaternion.tolist()
        found.append(message)
    return found


def main(args: Sequence[str] | None = None) -> None:
    """Run the node until it is told to stop."""
    run_node('arm_state', ArmStateNode, args=args)


if __name__ == '__main__':
    main()
