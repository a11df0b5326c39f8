"""Publishes joint states and references beside the thread that answers the controller."""

import contextlib
import queue
import sys
import threading

from rclpy.lifecycle import LifecycleNode
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState

from modal_core.nodes.run_node import RCLError
from robot_bridge.egm import RobotFeedback
from robot_bridge.node.joint_feed import Array, JointFeed
from robot_bridge.node.ros_messages import joint_state
from robot_bridge.operator import FlowState
from structural_model.flexible_joint_model import FlexibleJointModel

RELIABLE = QoSProfile(depth=1000, reliability=ReliabilityPolicy.RELIABLE)
PERIOD_S = 0.02


class JointPublisher:
    """Takes feedback and changes of state in the link's thread, tells them from its own.

    Parameters
    ----------
    node : LifecycleNode
        Whose topics ``joint_states`` and ``~/reference``, and whose log.
    """

    def __init__(self, node: LifecycleNode) -> None:
        self._node = node
        self._states = node.create_publisher(JointState, 'joint_states', RELIABLE)
        self._references = node.create_publisher(JointState, '~/reference', RELIABLE)
        self._changes: queue.SimpleQueue[tuple[FlowState, str]] = queue.SimpleQueue()
        self._closing = threading.Event()
        self._publish_states = True
        self._feed: JointFeed | None = None
        self._thread: threading.Thread | None = None

    def start(self, model: FlexibleJointModel, publish_states: bool = True) -> None:
        """Begin to publish the joints of a robot, or what is asked of them alone."""
        self._publish_states = publish_states
        self._feed = JointFeed(model)
        self._closing.clear()
        arguments = (self._feed, list(model.joint_names))
        self._thread = threading.Thread(
            target=self._run, args=arguments, name='joints', daemon=True
        )
        self._thread.start()

    def hear(self, feedback: RobotFeedback, receipt_ns: int, reference_deg: Array | None) -> None:
        """Take one feedback; returns at once."""
        if self._feed is not None:
            self._feed.add(feedback, receipt_ns, reference_deg)

    def tell(self, state: FlowState, reason: str) -> None:
        """Take a change of state for the log; returns at once."""
        self._changes.put((state, reason))

    def stop(self) -> None:
        """Publish no more."""
        self._closing.set()
        if self._thread is not None:
            self._thread.join(timeout=1.0)
        self._thread = None
        self._log_changes()

    def _run(self, feed: JointFeed, names: list[str]) -> None:
        while not self._closing.wait(PERIOD_S):
            with contextlib.suppress(RCLError):  # the context may end in between
                for sample in feed.samples():
                    stamp_ns = sample.stamp_ns
                    message = joint_state(names, stamp_ns, sample.position, sample.velocity)
                    if self._publish_states:
                        self._states.publish(message)
                    if sample.reference is not None:
                        self._references.publish(joint_state(names, stamp_ns, sample.reference))
            self._log_changes()

    def _log_changes(self) -> None:
        while not self._changes.empty():
            state, reason = self._changes.get()
            aborted, text = state == FlowState.ABORTED, f'{state.name}: {reason}'
            # rclpy allows one severity for each line of code.
            if self._node.context.ok() and aborted:
                self._node.get_logger().error(text)
            elif self._node.context.ok():
                self._node.get_logger().info(text)
            elif aborted:
                # Told to end in motion: what the operator must do now has no topic any more.
                sys.stderr.write(f'{self._node.get_name()}: {text}\n')
