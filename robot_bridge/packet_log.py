"""Every EGM datagram, both ways, into an MCAP file."""

import contextlib
from pathlib import Path
import queue
import threading

from google.protobuf import descriptor_pb2

from modal_core.errors import RecordingError
from recordings import RecordingWriter
from robot_bridge.egm_link import Packet
from robot_bridge.egm_messages import file_descriptor, PACKAGE

TOPICS = {False: ('egm/robot', 'EgmRobot'), True: ('egm/sensor', 'EgmSensor')}
LONGEST_QUEUE = 20_000


class PacketLog:
    """Writes packets from a thread of its own, so that the reply never waits for the disk.

    The messages are protobuf as on the wire, with their schema in the file; the verdict on each
    packet of the controller stands in the topic's name: ``egm/robot`` for accepted ones,
    ``egm/robot/<reason>`` for the others.  A full disk ends the log with its last whole chunk:
    what is in the file stays readable, and what comes later is counted in ``n_lost``.

    Parameters
    ----------
    path : Path
        File to write; it has a temporary name beside its own until it is closed.

    Raises
    ------
    RecordingError
        The file cannot be made.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.n_written = self.n_lost = 0
        self.failure = ''
        self._queue: queue.Queue[Packet | None] = queue.Queue(LONGEST_QUEUE)
        self._descriptors = descriptor_pb2.FileDescriptorSet(
            file=[file_descriptor()]
        ).SerializeToString()
        self._writer = RecordingWriter(path)
        self._thread = threading.Thread(target=self._run, name='packet_log', daemon=True)
        self._thread.start()

    def add(self, packet: Packet) -> None:
        """Queue one packet; never waits, a full queue loses and counts it."""
        try:
            self._queue.put_nowait(packet)
        except queue.Full:
            self.n_lost += 1

    def close(self) -> None:
        """Write what is queued and finish the file."""
        if self._thread.is_alive():
            with contextlib.suppress(queue.Full):
                self._queue.put(None, timeout=1.0)
            self._thread.join(timeout=5.0)

    def _run(self) -> None:
        while (packet := self._queue.get()) is not None:
            if self.failure:
                self.n_lost += 1
                continue
            try:
                self._write(packet)
            except (RecordingError, OSError) as error:
                self._fail(error)
        if not self.failure:
            try:
                self._writer.close()
            except (RecordingError, OSError) as error:
                self._fail(error)

    def _fail(self, error: Exception) -> None:
        """Note that the log has ended; the arm's motion does not depend on the disk."""
        self.failure = str(error)
        self.n_lost += 1

    def _write(self, packet: Packet) -> None:
        topic, kind = TOPICS[packet.sent]
        if packet.verdict != 'accept':
            topic = f'{topic}/{packet.verdict}'
        name = f'{PACKAGE}.{kind}'
        self._writer.add_protobuf_topic(topic, name, self._descriptors)
        self._writer.write(topic, name, packet.time_ns, packet.data)
        self.n_written += 1
