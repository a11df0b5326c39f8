"""The spindle's speed on a topic without stamps, put on the clock of the responses."""

from collections.abc import Sequence

import numpy as np
from rclpy.node import Node
from std_msgs.msg import Float64

from modal_core.nodes.polled_group_node import PolledGroup
from modal_core.spindle_speed import SpindleSpeed
from modal_recordings.spindle_speed import factor_of, FLOAT64, number_of
from oma_identifier.node.polled_topic_node import PolledTopic

DEPTH = 1000


class SpindleTopic:
    """Listens to the speed once somebody publishes it.

    Parameters
    ----------
    node : Node
        Gets the subscription.
    group : PolledGroup
        Of the node's polled subscriptions.
    topic : str
        Of std_msgs/Float64 [rpm], unless its name ends in _hz or _rad_s; empty: none.
    """

    def __init__(self, node: Node, group: PolledGroup, topic: str) -> None:
        self._node, self._group = node, group
        self._topic = node.resolve_topic_name(topic) if topic else ''
        self._polled: PolledTopic | None = None

    def look(self, topics: Sequence[tuple[str, Sequence[str]]]) -> None:
        """Subscribe where the topic has appeared among all topics and their types."""
        if self._polled is None and any(
            name == self._topic and FLOAT64 in types for name, types in topics
        ):
            self._polled = PolledTopic(self._node, self._group, self._topic, Float64, DEPTH)
            self._node.get_logger().info(f'listening to {self._topic} (speed of the spindle)')

    def take(self, now_ns: int | None) -> SpindleSpeed | None:
        """Return what has come since the last call.

        Parameters
        ----------
        now_ns : int or None [ns]
            Time of the newest sample, which the newest value belongs to; None before the first.
        """
        came = [] if self._polled is None else list(self._polled.take())
        if not came or now_ns is None:
            return None
        received = np.array([when for _, when in came], dtype=np.int64)
        values = np.array([number_of(raw, FLOAT64) for raw, _ in came])
        return SpindleSpeed.of(
            now_ns - (received.max() - received), factor_of(self._topic) * values
        )
