"""Records topics into an MCAP file as they arrive, without decoding them."""

from collections.abc import Mapping
import contextlib
from pathlib import Path
from typing import Any

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from modal_core.errors import RecordingError
from recordings.writer import RecordingWriter

DEPTH = 1000


class RecorderNode(Node):
    """Writes the serialised messages of some topics.

    Parameters
    ----------
    path : Path
        The .mcap file; it gets its name when the recorder is closed.
    topics : mapping of str to message class
        Absolute topic names and their types.
    latched : tuple of str
        Topics of transient-local durability.
    """

    def __init__(
        self,
        path: Path,
        topics: Mapping[str, type[Any]],
        latched: tuple[str, ...] = (),
        **options: Any,
    ) -> None:
        super().__init__('ama_recorder', **options)
        self.writer = RecordingWriter(path)
        self.failure = ''
        self._open = True
        for topic, message_type in topics.items():
            durable = topic in latched
            # Best effort hears reliable and best-effort publishers alike; blocks need reliability.
            profile = QoSProfile(
                depth=DEPTH,
                reliability=ReliabilityPolicy.RELIABLE,
                durability=DurabilityPolicy.TRANSIENT_LOCAL
                if durable
                else DurabilityPolicy.VOLATILE,
            )
            self.create_subscription(
                message_type, topic, self._writer_of(topic, message_type), profile, raw=True
            )

    def close(self) -> Path:
        """Finish the file and give it its name.

        Raises
        ------
        RecordingError
            The disk is full; what fitted is kept.
        """
        self._open = False
        return self.writer.close()

    def destroy_node(self) -> None:
        """Keep what was recorded, then end the node."""
        with contextlib.suppress(RecordingError):
            self.close()
        super().destroy_node()

    def _writer_of(self, topic: str, message_type: type[Any]) -> Any:
        package = message_type.__module__.split('.')[0]
        type_name = f'{package}/msg/{message_type.__name__}'

        def write(data: bytes) -> None:
            if not self._open:
                return
            now_ns = self.get_clock().now().nanoseconds
            try:
                self.writer.write(topic, type_name, now_ns, data)
            except RecordingError as error:
                self._open, self.failure = False, str(error)
                self.get_logger().error(self.failure)

        return write
