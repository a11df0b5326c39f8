"""Where the arm stands, taken from its joint states when somebody asks."""

from collections.abc import Sequence
import time

import numpy as np
from numpy.typing import NDArray
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState

from modal_core.errors import PlanError
from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_core.nodes.polled_group_node import PolledGroup

NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
# A bridge tells them in bunches every 20 ms; a busy machine takes a while.
PATIENCE_S, LOOK_S = 1.0, 0.02
TOPIC = 'joint_states'


class LatestJoints:
    """The newest joint states that come while somebody waits for them.

    Parameters
    ----------
    node : Node
        Whose namespace they are in.
    names : sequence of str
        Serial joints, in the order wanted.
    """

    def __init__(self, node: Node, names: Sequence[str]) -> None:
        self._names = tuple(names)
        self._subscription = node.create_subscription(
            JointState, TOPIC, lambda _: None, NEWEST, callback_group=PolledGroup()
        )

    def position(self) -> NDArray[np.float64]:
        """Return the joint angles as they come now, (n_joints,) [rad].

        Raises
        ------
        PlanError
            None of this arm came.
        """
        asked_ns = time.time_ns()
        while time.time_ns() < asked_ns + PATIENCE_S * NANOSECONDS_PER_SECOND:
            with self._subscription.handle:
                taken = self._subscription.handle.take_message(JointState, False)
            # What waited here since it was heard last may be long over.
            if taken and taken[1]['received_timestamp'] >= asked_ns:
                at = dict(zip(taken[0].name, taken[0].position, strict=False))
                if all(np.isfinite(at.get(name, np.nan)) for name in self._names):
                    return np.array([at[name] for name in self._names])
            time.sleep(LOOK_S)
        raise PlanError(
            'nobody tells where the arm stands',
            where=TOPIC,
            found=f'none of {", ".join(self._names)} for {PATIENCE_S:g} s',
            advice='start the bridge and its controller; a RAPID program tells only while it runs:'
            ' jog to the start pose, or plan the way: ama plan --approach-from',
        )
