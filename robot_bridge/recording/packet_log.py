"""Every EGM datagram, both ways, into MCAP files that stay within their room."""

from collections.abc import Mapping
import contextlib
from pathlib import Path
import queue
import struct
import threading
import time

from google.protobuf import descriptor_pb2

from modal_core.errors import RecordingError
from modal_recordings import RecordingWriter
from modal_recordings.bridge_events import EVENT_TOPIC, EVENT_TYPE
from modal_recordings.messages import ENCAPSULATION
from robot_bridge.egm import file_descriptor, PACKAGE, Packet

TOPICS = {False: ('egm/robot', 'EgmRobot'), True: ('egm/sensor', 'EgmSensor')}
LONGEST_QUEUE = 20_000
N_FILES = 4
FLUSH_S = 0.1
RECORD_BYTES = 64
"""What MCAP adds to each message, about."""


class PacketLog:
    """Writes packets from a thread of its own, so that the reply never waits for the disk.

    The messages are protobuf as on the wire, with their schema in the file; the verdict on each
    packet of the controller stands in the topic's name: ``egm/robot`` for accepted ones,
    ``egm/robot/<reason>`` for the others.  Every state of the bridge and the reason for it is on
    ``robot_bridge/events``.

    What is queued is in the file a tenth of a second later, and every state at once: whatever ends
    the process, the end of the record is there, in ``<name>.unfinished.mcap``.

    A quarter of the room is one file; the next one is named ``<name>_1.mcap`` and so on, and
    the oldest is deleted before the room runs out.  On a full disk older files of this run make
    room too; without any the log ends with its last whole chunk: what is in it stays readable,
    and what comes later is counted in ``n_lost``.

    Parameters
    ----------
    path : Path
        First file; each is named ``<name>.unfinished.mcap`` until it is closed.
    largest_bytes : int
        Room for all files together.
    attached : mapping of str to bytes
        Files that each of them carries, by name.

    Raises
    ------
    RecordingError
        The file cannot be made.
    """

    def __init__(
        self,
        path: Path,
        largest_bytes: int = 500_000_000,
        attached: Mapping[str, bytes] | None = None,
    ) -> None:
        self.path, self._attached = path, attached or {}
        self.n_written = self.n_lost = self.n_files_deleted = 0
        self.failure = ''
        self._file_bytes = largest_bytes // N_FILES
        self._queue: queue.Queue[Packet | tuple[int, str] | None] = queue.Queue(LONGEST_QUEUE)
        self._descriptors = descriptor_pb2.FileDescriptorSet(
            file=[file_descriptor()]
        ).SerializeToString()
        self._n_files, self._n_bytes = 0, 0
        self._flush_due_s = time.monotonic() + FLUSH_S
        self._kept: list[Path] = []
        self._writer = self._next_file()
        self._thread = threading.Thread(target=self._run, name='packet_log', daemon=True)
        self._thread.start()

    def add(self, packet: Packet) -> None:
        """Queue one packet; never waits, a full queue loses and counts it."""
        self._put(packet)

    def add_event(self, time_ns: int, text: str) -> None:
        """Queue what happened, in words."""
        self._put((time_ns, text))

    def close(self) -> None:
        """Write what is queued and finish the file."""
        if self._thread.is_alive():
            with contextlib.suppress(queue.Full):
                self._queue.put(None, timeout=1.0)
            self._thread.join(timeout=5.0)

    def _put(self, item: Packet | tuple[int, str]) -> None:
        try:
            self._queue.put_nowait(item)
        except queue.Full:
            self.n_lost += 1

    def _run(self) -> None:
        while (item := self._next()) is not None:
            if self.failure:
                self.n_lost += 1
                continue
            try:
                self._write(item)
                self._flush(item)
                if self._n_bytes > self._file_bytes:
                    self._turn_over()
            except (RecordingError, OSError) as error:
                self._make_room(error)
        if not self.failure:
            try:
                self._writer.close()
            except (RecordingError, OSError) as error:
                self._fail(error)

    def _next(self) -> Packet | tuple[int, str] | None:
        """Wait for something to write; flush what was written when nothing comes."""
        while True:
            try:
                return self._queue.get(timeout=FLUSH_S)
            except queue.Empty:
                if not self.failure:
                    try:
                        self._writer.flush()
                    except (RecordingError, OSError) as error:
                        self._make_room(error)

    def _flush(self, item: Packet | tuple[int, str]) -> None:
        """Flush when it is time, and whenever the state of the bridge changes."""
        now_s = time.monotonic()
        if not isinstance(item, Packet) or now_s >= self._flush_due_s:
            self._writer.flush()
            self._flush_due_s = now_s + FLUSH_S

    def _turn_over(self) -> None:
        """Go on in the next file, and delete the oldest before the room runs out."""
        self._kept.append(self._writer.close())
        while len(self._kept) >= N_FILES:
            self._delete_oldest()
        self._writer = self._next_file()

    def _next_file(self) -> RecordingWriter:
        suffix = f'_{self._n_files}' if self._n_files else ''
        path = self.path.with_stem(self.path.stem + suffix)
        writer = RecordingWriter(path, attached=self._attached)
        self._n_files += 1
        self._n_bytes = sum(map(len, self._attached.values()))
        return writer

    def _make_room(self, error: Exception) -> None:
        """Go on after a full disk, as long as an older file can give way."""
        self.n_lost += 1
        if not self._kept:
            self._fail(error)
            return
        self._delete_oldest()
        self._kept.append(self._writer.path)
        try:
            self._writer = self._next_file()
        except (RecordingError, OSError) as other:
            self._fail(other)

    def _delete_oldest(self) -> None:
        self._kept.pop(0).unlink(missing_ok=True)
        self.n_files_deleted += 1

    def _fail(self, error: Exception) -> None:
        """Note that the log has ended; the arm's motion does not depend on the disk."""
        self.failure = str(error)

    def _write(self, item: Packet | tuple[int, str]) -> None:
        if isinstance(item, Packet):
            topic, kind = TOPICS[item.sent]
            if item.verdict != 'accept':
                topic = f'{topic}/{item.verdict}'
            name, time_ns, data = f'{PACKAGE}.{kind}', item.time_ns, item.data
            self._writer.add_protobuf_topic(topic, name, self._descriptors)
        else:
            topic, name, (time_ns, text) = EVENT_TOPIC, EVENT_TYPE, item
            letters = text.encode() + b'\x00'
            data = ENCAPSULATION + struct.pack('<I', len(letters)) + letters
        self._writer.write(topic, name, time_ns, data)
        self._n_bytes += len(data) + RECORD_BYTES
        self.n_written += 1
