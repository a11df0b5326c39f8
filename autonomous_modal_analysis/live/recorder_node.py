"""Records topics into an MCAP file as they arrive, without decoding them."""

from collections import deque
from collections.abc import Mapping
import contextlib
from pathlib import Path
import threading
import time
from typing import Any

from rclpy.node import Node

from modal_core.errors import RecordingError
from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_core.nodes.polled_group_node import PolledGroup
from modal_recordings.containers import RecordingWriter
from modal_recordings.messages import RawMessage
from oma_identifier.node.polled_topic_node import PolledTopic

DEPTH = 8000
POLL_S = 0.05
FLUSH_S = 0.1


class RecorderNode(Node):
    """Writes the serialised messages of some topics.

    Parameters
    ----------
    path : Path
        The .mcap file; ``<name>.unfinished.mcap`` until the recorder is closed.
    topics : mapping of str to message class
        Absolute topic names and their types.
    latched : tuple of str
        Topics of transient-local durability.
    held_s : float [s]
        Write nothing before :meth:`begin`, then also what came so long before it; 0: write all.
    attached : mapping of str to bytes
        Files that the recording carries, by name.

    Attributes
    ----------
    keep : bool
        Whether the file stays when the node ends.
    """

    def __init__(
        self,
        path: Path,
        topics: Mapping[str, type[Any]],
        latched: tuple[str, ...] = (),
        held_s: float = 0.0,
        attached: Mapping[str, bytes] | None = None,
        **options: Any,
    ) -> None:
        super().__init__('ama_recorder', **options)
        self.writer: RecordingWriter | None = None
        self._path, self._attached = path, attached
        self.failure = ''
        self.keep = True
        self._open = True
        self._held_ns = round(held_s * NANOSECONDS_PER_SECOND)
        self._held: deque[RawMessage] = deque()
        self._flush_due_s = 0.0
        if held_s <= 0.0:
            self.begin()
        self._latched = frozenset(latched)
        self._lock = threading.Lock()
        group = PolledGroup()
        self._topics = {
            topic: (
                _type_name(kind),
                PolledTopic(self, group, topic, kind, DEPTH, topic in latched),
            )
            for topic, kind in topics.items()
        }
        self.create_timer(POLL_S, self._poll)

    def begin(self) -> None:
        """Write what was held, and what comes from now on.

        Raises
        ------
        RecordingError
            The file cannot be made.
        """
        if self.writer is None:
            self.writer = RecordingWriter(self._path, attached=self._attached)

    def close(self) -> Path:
        """Finish the file and give it its name.

        Raises
        ------
        RecordingError
            The disk is full; what fitted is kept.
        """
        self._poll()
        with self._lock:
            self._open = False
            return self.writer.close() if self.writer is not None else self._path

    def destroy_node(self) -> None:
        """Keep what was recorded, or not, then end the node."""
        with contextlib.suppress(RecordingError):
            if self.keep:
                self.close()
            elif self.writer is not None:
                self.writer.discard()
        super().destroy_node()

    def _poll(self) -> None:
        """Take what has come of all topics, in the order it came."""
        with self._lock:
            if not self._open:
                return
            self._held += sorted(
                (
                    RawMessage(topic, type_name, received_ns, data)
                    for topic, (type_name, subscription) in self._topics.items()
                    for data, received_ns in subscription.take()
                ),
                key=lambda message: message.log_time_ns,
            )
            if self.writer is not None:
                self._write_held(self.writer)
            elif self._held:
                self._forget(self._held[-1].log_time_ns - self._held_ns)

    def _forget(self, before_ns: int) -> None:
        """Drop what is too old; a latched message is never repeated and stays."""
        self._held = deque(
            message
            for message in self._held
            if message.log_time_ns >= before_ns or message.topic in self._latched
        )

    def _write_held(self, writer: RecordingWriter) -> None:
        """Write, and flush often: whatever ends the process, the end of the record is there."""
        try:
            while self._held:
                writer.write(*self._held.popleft())
            if time.monotonic() >= self._flush_due_s:
                writer.flush()
                self._flush_due_s = time.monotonic() + FLUSH_S
        except RecordingError as error:
            self._open, self.failure = False, str(error)
            self.get_logger().error(self.failure)


def _type_name(kind: type[Any]) -> str:
    return f'{kind.__module__.split(".")[0]}/msg/{kind.__name__}'
