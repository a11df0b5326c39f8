"""Write an MCAP recording that stays readable whatever stops it."""

from collections.abc import Mapping
import contextlib
import errno
from io import FileIO
import itertools
import os
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from mcap.exceptions import McapError
from mcap.writer import CompressionType, Writer

from modal_core.errors import RecordingError
from modal_core.files.version import software
from modal_recordings.containers.mcap_chunk import RECORD
from modal_recordings.messages import definition, media_type, SOFTWARE

CHUNK_BYTES = 256 * 1024
MAGIC = b'\x89MCAP0\r\n'
DATA_END, FOOTER = 15, 2
END_WITHOUT_INDEX = (
    RECORD.pack(DATA_END, 4) + bytes(4) + RECORD.pack(FOOTER, 20) + bytes(20) + MAGIC
)


class RecordingWriter:
    """Record serialised ROS 2 messages into an MCAP file.

    Chunks are small, so that a crash costs little, and :meth:`flush` ends one at once; the file is
    ``<name>.unfinished.mcap`` beside its own name until it is closed, and never replaces one that
    a crash has left.  When the disk is full the recording ends with the last whole chunk and
    is still readable; a file that has its name already stays, and it keeps the other one.

    Parameters
    ----------
    path : Path
        Where the file shall end up; replaced when it exists.
    compression : str
        ``none`` or ``zstd``.
    attached : mapping of str to bytes
        Files that the recording carries, by name; name and version of this software are carried
        always (``software.txt``).

    Raises
    ------
    RecordingError
        The file cannot be made or, from :meth:`write`, the disk is full.
    """

    def __init__(
        self,
        path: str | Path,
        compression: str = 'none',
        attached: Mapping[str, bytes] | None = None,
    ) -> None:
        self.path = Path(path)
        self.n_messages = 0
        self.stopped = ''
        self._channels: dict[str, tuple[int, str]] = {}
        self._good_ends = [0, 0]
        kinds = {'none': CompressionType.NONE, 'zstd': CompressionType.ZSTD}
        if compression not in kinds:
            raise RecordingError(
                'unknown compression', found=compression, expected=', '.join(kinds)
            )
        if self.path.is_dir():
            raise RecordingError('cannot be written: a folder has its name', where=path)
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._file = _new_file(self.path)
        except OSError as error:
            raise RecordingError(f'cannot be written: {error.strerror}', where=path) from error
        self.temporary = Path(self._file.name)
        self._stream = WholeWrites(self._file)
        self._writer = Writer(
            self._stream,
            chunk_size=CHUNK_BYTES,
            compression=kinds[compression],
        )
        try:
            self._writer.start(profile='ros2', library='autonomous_modal_analysis')
            self._attach({**(attached or {}), SOFTWARE: f'{software()}\n'.encode()})
        except OSError as error:
            self.discard()
            raise RecordingError(f'cannot be written: {error.strerror}', where=path) from error
        self._good_ends = [self._stream.position, self._stream.position]

    def add_topic(self, topic: str, message_type: str, message_definition: str = '') -> None:
        """Declare a topic; its definition is looked up unless given.

        Raises
        ------
        RecordingError
            Unknown type, or the topic is already declared with another one.
        """
        known = self._channels.get(topic)
        if known is not None:
            if known[1] != message_type:
                raise RecordingError(
                    'topic declared with two types',
                    where=topic,
                    found=message_type,
                    expected=known[1],
                )
            return
        text = message_definition or definition(message_type)
        schema = self._writer.register_schema(message_type, 'ros2msg', text.encode())
        channel = self._writer.register_channel(topic, 'cdr', schema)
        self._channels[topic] = (channel, message_type)

    def add_protobuf_topic(self, topic: str, message_type: str, descriptors: bytes) -> None:
        """Declare a topic of protobuf messages.

        Parameters
        ----------
        topic, message_type : str
            Name, and full name of the message.
        descriptors : bytes
            Serialised ``FileDescriptorSet`` that defines it.
        """
        if topic not in self._channels:
            schema = self._writer.register_schema(message_type, 'protobuf', descriptors)
            channel = self._writer.register_channel(topic, 'protobuf', schema)
            self._channels[topic] = (channel, message_type)

    def write(self, topic: str, message_type: str, log_time_ns: int, data: bytes) -> None:
        """Append one serialised message.

        Raises
        ------
        RecordingError
            The disk is full: what was written so far is kept and readable; or the writer has
            already stopped.
        """
        if self.stopped:
            raise RecordingError('recording has stopped', where=self.path, found=self.stopped)
        if topic not in self._channels:
            self.add_topic(topic, message_type)
        try:
            self._writer.add_message(
                self._channels[topic][0],
                log_time=log_time_ns,
                data=data,
                publish_time=log_time_ns,
                sequence=self.n_messages & 0xFFFFFFFF,
            )
        except OSError as error:
            self._stop_early(error)
        self.n_messages += 1
        self._note_end()

    def flush(self) -> None:
        """End the chunk: a process that is killed loses nothing that was written before.

        Raises
        ------
        RecordingError
            As :meth:`write`.
        """
        if self.stopped or self._file.closed:
            return
        # Older releases of mcap have no flush, only what it calls.
        within: Any = getattr(self._writer, '_Writer__finalize_chunk', None)
        end_chunk = getattr(self._writer, 'flush', within)
        try:
            end_chunk()
        except OSError as error:
            self._stop_early(error)
        self._note_end()

    def close(self) -> Path:
        """Finish the file and give it its name.

        Raises
        ------
        RecordingError
            The index did not fit on the disk; the messages are kept.
        """
        if self._file.closed:
            return self.path
        try:
            self._writer.finish()
        except (OSError, McapError) as error:
            self._stop_early(error)
        self._finish()
        return self.path

    def discard(self) -> None:
        """Give up: nothing is left on the disk."""
        self._file.close()
        self.temporary.unlink(missing_ok=True)

    def _attach(self, files: Mapping[str, bytes]) -> None:
        """Write files before all messages, where a crash of any kind leaves them."""
        for name, data in files.items():
            # No times: the same messages make the same file.
            self._writer.add_attachment(
                create_time=0, log_time=0, name=name, media_type=media_type(name), data=data
            )

    def _note_end(self) -> None:
        if self._stream.position != self._good_ends[-1]:
            self._good_ends.append(self._stream.position)
            del self._good_ends[:-3]

    def _stop_early(self, error: Exception) -> None:
        """End the file after the last whole chunk, without an index, and keep it."""
        reason = getattr(error, 'strerror', None) or str(error)
        self.stopped = reason
        for end in reversed(self._good_ends):
            try:
                self._file.truncate(end)
                self._file.seek(end)
                self._stream.write(END_WITHOUT_INDEX)
                break
            except OSError:
                continue
        # Half a recording is no reason to lose a whole one.
        asked = self.path
        self.path = self.temporary if asked.exists() else asked
        self._finish()
        raise RecordingError(
            f'recording stopped: {reason}',
            where=asked,
            advice=f'what was recorded before is kept in {self.path.name}',
        ) from error

    def _finish(self) -> None:
        try:
            os.fsync(self._file.fileno())
        except OSError as error:
            if error.errno not in (errno.EINVAL, errno.ENOSPC):
                raise RecordingError(f'cannot be written: {error}', where=self.path) from error
        self._file.close()
        try:
            os.replace(self.temporary, self.path)
        except OSError as error:
            raise RecordingError(
                f'cannot get its name: {error.strerror}',
                where=self.path,
                advice=f'the recording is kept in {self.temporary.name}',
            ) from error

    def __enter__(self) -> Self:
        """Return the writer."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close the file, or discard it when the block failed for another reason."""
        if self._file.closed:
            return
        if kind is None:
            self.close()
        else:
            self.discard()


def _new_file(path: Path) -> FileIO:
    """Create the file that is written to: one that was left there is somebody's evidence."""
    for number in itertools.count():
        suffix = f'_{number}' if number else ''
        with contextlib.suppress(FileExistsError):
            place = path.with_name(f'{path.stem}.unfinished{suffix}{path.suffix}')
            return place.open('xb', buffering=0)
    raise AssertionError('unreachable')


class WholeWrites:
    """A stream that writes all bytes or raises, and knows its position."""

    def __init__(self, file: object) -> None:
        self._file = file
        self.position = 0

    def write(self, data: bytes) -> int:
        """Write all of it, however often the file must be asked."""
        rest = memoryview(data)
        while rest:
            count = self._file.write(rest)  # type: ignore[attr-defined]
            self.position += count
            rest = rest[count:]
        return len(data)

    def tell(self) -> int:
        """Return how many bytes were written."""
        return self.position

    def flush(self) -> None:
        """Nothing is buffered."""
