"""A plain number per mode and window: what plotters of numbers draw over time."""

import queue

from rclpy.node import Node
from rclpy.publisher import Publisher
from std_msgs.msg import Float64

from modal_core.mode import Mode
from modal_core.nodes.ros_messages import LATCHED
from oma_identifier.result import WindowResult

MOST_MODES = 32
"""With topics at a time: ids go on rising, and each topic costs every process of the network."""
PERIOD_S = 0.1
FIELDS = ('frequency_hz', 'damping_ratio')


class ModeTopics:
    """Publishes ``~/mode_<id>/frequency_hz`` and ``~/mode_<id>/damping_ratio``.

    A mode that was not seen for the longest time gives its topics up for a new one.

    Parameters
    ----------
    node : Node
        Gets the publishers.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._results: queue.SimpleQueue[WindowResult] = queue.SimpleQueue()
        node.create_timer(PERIOD_S, self._publish)
        self._publishers: dict[int, tuple[Publisher, ...]] = {}

    def take(self, result: WindowResult) -> None:
        """Tell the modes of a window; from any thread."""
        self._results.put(result)

    def _publish(self) -> None:
        while not self._results.empty():
            for mode in self._results.get().modes:
                if mode.id:
                    self._tell(mode)

    def _tell(self, mode: Mode) -> None:
        publishers = self._publishers.pop(mode.id, None)
        if publishers is None:
            publishers = tuple(
                self._node.create_publisher(Float64, f'~/mode_{mode.id}/{name}', LATCHED)
                for name in FIELDS
            )
        # Last in order: seen last.
        self._publishers[mode.id] = publishers
        while len(self._publishers) > MOST_MODES:
            for each in self._publishers.pop(next(iter(self._publishers))):
                self._node.destroy_publisher(each)
        for publisher, name in zip(publishers, FIELDS, strict=True):
            publisher.publish(Float64(data=float(getattr(mode, name))))
