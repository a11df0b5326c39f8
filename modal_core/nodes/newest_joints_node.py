"""The newest joint states, taken when somebody looks."""

from collections.abc import Sequence
from dataclasses import dataclass

from builtin_interfaces.msg import Time
import numpy as np
from numpy.typing import NDArray
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState

from modal_core.nodes.polled_group_node import PolledGroup

NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)


@dataclass(frozen=True, slots=True)
class ArmPose:
    """Where the arm was.

    Parameters
    ----------
    position : (n_joints,) array [rad]
        Serial joints.
    stamp : Time
        When.
    """

    position: NDArray[np.float64]
    stamp: Time


class NewestJoints:
    """Takes the newest joint states that came since somebody looked last.

    Parameters
    ----------
    node : Node
        Gets the subscription.
    topic : str
        Of the joint states.
    names : sequence of str
        Serial joints, in the order wanted.
    """

    def __init__(self, node: Node, topic: str, names: Sequence[str]) -> None:
        self._names = tuple(names)
        self._subscription = node.create_subscription(
            JointState, topic, lambda _: None, NEWEST, callback_group=PolledGroup()
        )

    def take(self) -> ArmPose | None:
        """Return where the arm is; None where nothing of this arm came."""
        with self._subscription.handle:
            taken = self._subscription.handle.take_message(JointState, False)
        if not taken:
            return None
        message = taken[0]
        at = dict(zip(message.name, message.position, strict=False))
        position = np.array([at.get(name, np.nan) for name in self._names])
        return ArmPose(position, message.header.stamp) if np.isfinite(position).all() else None
