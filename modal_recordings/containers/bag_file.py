"""Read rosbag2 folders, bare .db3 files and ROS 1 bags through rosbags."""

from collections.abc import Iterator
from pathlib import Path
import struct

import apsw
from rosbags.rosbag1 import Reader as Rosbag1Reader
from rosbags.rosbag1 import ReaderError as Rosbag1Error
from rosbags.rosbag2 import Reader as Rosbag2Reader
from rosbags.rosbag2 import ReaderError as Rosbag2Error

from modal_core.errors import RecordingError
from modal_recordings.disk import check_unpacked_size, unreadable_bag, unreadable_database
from modal_recordings.messages import Attachment, bunched, Kept, RawMessage, TopicEntry

READ_ERRORS = (
    Rosbag1Error,
    Rosbag2Error,
    apsw.Error,
    struct.error,
    OSError,
    EOFError,
    MemoryError,
    RuntimeError,
    ValueError,
    LookupError,
    TypeError,
    AttributeError,
    AssertionError,
)


class BagFile:
    """A rosbag2 folder, a bare .db3 file or a ROS 1 bag.

    Parameters
    ----------
    path : Path
        File or folder.

    Raises
    ------
    RecordingError
        It cannot be opened.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.ros1 = path.suffix == '.bag'
        self.kind = 'rosbag1' if self.ros1 else 'rosbag2'
        self._damage: tuple[str, ...] = ()
        # The reader unpacks whole files before it looks at them.
        check_unpacked_size(path)
        try:
            with self._open() as reader:
                self._topics = tuple(
                    TopicEntry(
                        name=name,
                        message_type=topic.msgtype or '',
                        definition='' if self.ros1 else topic.msgdef.data,
                        n_messages=topic.msgcount,
                    )
                    for name, topic in sorted(reader.topics.items())
                )
        except READ_ERRORS as error:
            raise self._unreadable(error) from error

    def topics(self) -> tuple[TopicEntry, ...]:
        """Return the topics it names."""
        return self._topics

    def messages(self, topics: frozenset[str] | None = None) -> Iterator[RawMessage]:
        """Yield messages in log order, as far as the file can be read."""
        self._damage = ()
        n_read = 0
        expected = sum(
            entry.n_messages or 0
            for entry in self._topics
            if topics is None or entry.name in topics
        )
        try:
            with self._open() as reader:
                wanted = [
                    connection
                    for connection in reader.connections
                    if topics is None or connection.topic in topics
                ]
                if not wanted:
                    return
                for connection, log_time, data in reader.messages(connections=wanted):
                    n_read += 1
                    yield RawMessage(connection.topic, connection.msgtype, log_time, data)
        except READ_ERRORS as error:
            share = 100.0 * max(0, expected - n_read) / max(1, expected)
            self._damage = (
                f'{n_read} of {expected} messages read, {share:.1f} % lost: {one_line(error)}',
            )
            return
        if n_read < expected:
            share = 100.0 * (expected - n_read) / expected
            self._damage = (f'{n_read} of {expected} messages read, {share:.1f} % lost',)

    def bunches(self, topics: frozenset[str] | None = None) -> Iterator[list[Kept]]:
        """Yield the same, many at once."""
        return bunched(self.messages(topics))

    def attachments(self) -> tuple[Attachment, ...]:
        """Return none: bags of this kind carry no files."""
        return ()

    def damage(self) -> tuple[str, ...]:
        """Return what the last full pass could not read."""
        return self._damage

    def _unreadable(self, error: BaseException) -> RecordingError:
        """Return why it cannot be opened: by its own bytes, else as the library says."""
        reason = None
        if self.ros1:
            reason = unreadable_bag(self.path)
        elif self.path.is_file():
            reason = unreadable_database(self.path)
        else:
            databases = sorted(self.path.glob('*.db3'))
            reason = next(filter(None, map(unreadable_database, databases)), None)
        return reason or RecordingError(
            f'not a readable {self.kind}: {one_line(error)}', where=self.path
        )

    def _open(self) -> Rosbag1Reader | Rosbag2Reader:
        # Not the reader of both kinds: it refuses a bag for one definition it cannot parse.
        return Rosbag1Reader(self.path) if self.ros1 else Rosbag2Reader(self.path)


def one_line(error: BaseException) -> str:
    """Return an exception as one short line."""
    text = ' '.join(str(error).split()) or type(error).__name__
    return text[:200]
