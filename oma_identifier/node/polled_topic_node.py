"""Subscriptions whose messages are taken in batches, as serialised: far cheaper than callbacks."""

from collections.abc import Iterator
from typing import Any

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from modal_core.nodes.polled_group_node import PolledGroup


class PolledTopic:
    """One topic of serialised messages.

    Parameters
    ----------
    node : Node
        Gets the subscription.
    group : PolledGroup
        Of the node's polled subscriptions.
    topic : str
        Its publishers decide on reliability: a reliable subscription hears nothing from a
        best-effort publisher.
    message_class : type
        Of its messages.
    depth : int
        Messages that may wait.
    latched : bool
        Take the last message of before, too.
    """

    def __init__(
        self,
        node: Node,
        group: PolledGroup,
        topic: str,
        message_class: type[Any],
        depth: int,
        latched: bool = False,
    ) -> None:
        self._message_class = message_class
        reliable = all(
            info.qos_profile.reliability == ReliabilityPolicy.RELIABLE
            for info in node.get_publishers_info_by_topic(topic)
        )
        profile = QoSProfile(
            depth=depth,
            reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
            durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
        )
        self._subscription = node.create_subscription(
            message_class, topic, lambda _: None, profile, callback_group=group, raw=True
        )

    def take(self) -> Iterator[tuple[bytes, int]]:
        """Yield what waits: the serialised message, and when it was received [ns]."""
        with self._subscription.handle:
            while True:
                taken = self._subscription.handle.take_message(self._message_class, True)
                if taken is None:
                    return
                yield taken[0], taken[1]['received_timestamp']
