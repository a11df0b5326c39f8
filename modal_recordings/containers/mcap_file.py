"""Read an MCAP file front to back, past damage, and say what was lost.

The usual readers start from the index at the end of the file and give up when it is missing; a
recorder that lost power leaves exactly such a file.  Walking the records front to back needs no
index, and a damaged chunk costs only itself.

References
----------
.. [1] MCAP file format specification, https://mcap.dev/spec
"""

from collections.abc import Iterator
from io import BytesIO
import mmap
from operator import itemgetter
from pathlib import Path
import struct
from typing import Any

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.records import Channel, Chunk, Header, Schema, Statistics

from modal_core.errors import RecordingError
from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_recordings.containers.mcap_attachments import (
    indexed_places,
    leading_places,
    read_attachments,
)
from modal_recordings.containers.mcap_chunk import (
    CHANNEL,
    CHUNK,
    chunk_head,
    ChunkHead,
    cut_records,
    MESSAGE_OPCODE,
    next_chunk,
    RECORD,
    records_of,
    SCHEMA,
    uncompress,
)
from modal_recordings.containers.mcap_order import (
    by_log_time,
    ChunkPlace,
    indexed_chunks,
    out_of_order,
)
from modal_recordings.disk import ReadPages
from modal_recordings.messages import Attachment, Kept, one_by_one, RawMessage, TopicEntry

MAGIC = b'\x89MCAP0\r\n'
HEADER, FOOTER, STATISTICS, DATA_END = 1, 2, 11, 15
FOOTER_BYTES = 37
KNOWN_OPCODES = frozenset(range(1, 16))
PARSE_ERRORS = (
    McapError, struct.error, UnicodeDecodeError, ValueError, EOFError, MemoryError, OverflowError,
)  # fmt: skip
MOST_DAMAGE_STATEMENTS = 20


class McapFile:
    """An MCAP file of ROS 2 messages.

    Parameters
    ----------
    path : Path
        The file.

    Raises
    ------
    RecordingError
        Empty, not MCAP, or not recorded by ROS 2.
    """

    kind = 'mcap'
    ros1 = False

    def __init__(self, path: Path) -> None:
        self.path = path
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, Channel] = {}
        self._n_messages: dict[int, int] = {}
        self._n_bytes = 0
        self._damage: list[str] = []
        self._end = ''
        self._known = False
        self._indexed: Statistics | None = None
        self._check_start()

    def topics(self) -> tuple[TopicEntry, ...]:
        """Return the topics found by a pass over the file, with their message counts."""
        if not self._known:
            self._known = self._read_index(self._summary())
        if not self._known:
            for _ in self.bunches(frozenset()):
                pass
        entries: dict[str, TopicEntry] = {}
        for key, channel in sorted(self._channels.items(), key=lambda item: item[1].topic):
            schema = self._schemas.get(channel.schema_id)
            before = entries.get(channel.topic)
            entries[channel.topic] = TopicEntry(
                name=channel.topic,
                message_type=schema.name if schema else '',
                definition=_definition(schema),
                encoding=channel.message_encoding,
                n_messages=self._n_messages.get(key, 0)
                + (before.n_messages or 0 if before else 0),
            )
        return tuple(entries.values())

    def messages(self, topics: frozenset[str] | None = None) -> Iterator[RawMessage]:
        """Yield messages by log time; where the file has no index, sorted within a chunk."""
        return one_by_one(self.bunches(topics))

    def bunches(self, topics: frozenset[str] | None = None) -> Iterator[list[Kept]]:
        """Yield the same, many at once."""
        with self.path.open('rb') as file:
            size = self.path.stat().st_size
            with mmap.mmap(file.fileno(), size, access=mmap.ACCESS_READ) as data:
                places = self._out_of_order(data)
                self._n_messages = {}
                self._n_bytes = 0
                self._damage = []
                self._end = ''
                if places:
                    yield from by_log_time(self._by_index(data, places, topics))
                else:
                    self._indexed = None
                    yield from self._walk(data, topics)
        self._close_accounts()
        self._known = True

    def attachments(self) -> tuple[Attachment, ...]:
        """Return the files it carries; without an index those that stand before all messages."""
        with (
            self.path.open('rb') as file,
            mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data,
        ):
            summary = self._summary()
            try:
                places = None if summary is None else indexed_places(summary)
            except RecordingError:
                places = None
            first = leading_places(data, len(MAGIC))
            return read_attachments(data, first if places is None else places)

    def _summary(self) -> bytes | None:
        """Return the records of the index at the end; None when it is missing."""
        with self.path.open('rb') as file:
            file.seek(0, 2)
            size = file.tell()
            if size < len(MAGIC) + FOOTER_BYTES:
                return None
            file.seek(size - FOOTER_BYTES)
            tail = file.read(FOOTER_BYTES)
            if tail[:9] != RECORD.pack(FOOTER, 20) or tail[-8:] != MAGIC:
                return None
            (start,) = struct.unpack_from('<Q', tail, 9)
            if not len(MAGIC) <= start < size - FOOTER_BYTES:
                return None
            file.seek(start)
            return file.read(size - FOOTER_BYTES - start)

    def _read_index(self, summary: bytes | None) -> bool:
        """Learn the topics from the index at the end; False when it is damaged or missing."""
        if summary is None:
            return False
        try:
            for opcode, _, _, content in records_of(summary):
                self._describe(opcode, content)
                if opcode == STATISTICS:
                    self._indexed = _parse(Statistics, content)
        except RecordingError:
            return False
        if self._indexed is None or self._indexed.channel_count > len(self._channels):
            return False
        self._n_messages = dict(self._indexed.channel_message_counts)
        return True

    def damage(self) -> tuple[str, ...]:
        """Return what the last full pass could not read."""
        if len(self._damage) > MOST_DAMAGE_STATEMENTS:
            more = len(self._damage) - MOST_DAMAGE_STATEMENTS
            return (*self._damage[:MOST_DAMAGE_STATEMENTS], f'and {more} more')
        return tuple(self._damage)

    def _check_start(self) -> None:
        try:
            with self.path.open('rb') as file:
                start = file.read(len(MAGIC))
                head = file.read(4096)
        except OSError as error:
            raise RecordingError(f'cannot be read: {error.strerror}', where=self.path) from error
        if not start:
            raise RecordingError('empty file', where=self.path, found='0 bytes', expected='MCAP')
        if start != MAGIC:
            raise RecordingError(
                'not an MCAP file',
                where=self.path,
                found='other first bytes',
                expected=repr(MAGIC),
            )
        try:
            header = Header.read(_stream(head[RECORD.size :])) if head[:1] == b'\x01' else None
        except PARSE_ERRORS:
            header = None
        if header is not None and header.profile not in ('ros2', ''):
            raise RecordingError(
                'wrong MCAP profile', where=self.path, found=repr(header.profile), expected='ros2'
            )

    def _walk(self, data: mmap.mmap, topics: frozenset[str] | None) -> Iterator[list[Kept]]:
        position, size, rest = len(MAGIC), len(data), 'what followed is unknown'
        pages = ReadPages(data)
        while position + RECORD.size <= size:
            opcode, length = RECORD.unpack_from(data, position)
            start = position + RECORD.size
            stop = start + length
            if opcode not in KNOWN_OPCODES or stop > size:
                head = chunk_head(data, start) if opcode == CHUNK else None
                if head is not None and head.length == length:
                    yield self._cut_chunk(data, head, topics)
                    return
                resumed = next_chunk(data, position + 1)
                if resumed is None and opcode in KNOWN_OPCODES and data[-len(MAGIC) :] != MAGIC:
                    break
                self._lost('damaged record', position, size if resumed is None else resumed)
                if resumed is None:
                    return
                position = resumed
                continue
            position = stop
            if opcode == FOOTER:
                return
            if opcode == DATA_END:
                rest = 'no message lost'
            try:
                found = self._record(opcode, data[start:stop], topics)
            except RecordingError as error:
                self._lost(str(error), start - RECORD.size, stop)
            else:
                if found:
                    yield found
            pages.read(length)
        where = 'without an end mark' if position == size else 'inside a record'
        self._end = f'file ends at byte {size} {where}, {rest}'

    def _out_of_order(self, data: mmap.mmap) -> list[ChunkPlace]:
        """Return the chunks by their first log times where the file has them otherwise."""
        summary = self._summary()
        try:
            places = [] if summary is None else indexed_chunks(summary)
        except RecordingError:
            return []
        if not out_of_order(places) or not self._read_index(summary):
            return []
        for place in places:
            start = place.offset + RECORD.size
            head = chunk_head(data, start) if place.offset < len(data) else None
            if head is None or RECORD.size + head.length != place.length:
                return []
        return sorted(places)

    def _by_index(
        self, data: mmap.mmap, places: list[ChunkPlace], topics: frozenset[str] | None
    ) -> Iterator[tuple[int, list[Kept]]]:
        """Yield the first log time of each chunk and its messages, one after the other."""
        pages = ReadPages(data)
        for place in places:
            start, stop = place.offset + RECORD.size, place.offset + place.length
            try:
                found = self._record(CHUNK, data[start:stop], topics)
            except RecordingError as error:
                self._lost(str(error), place.offset, stop)
            else:
                yield place.start_ns, found
            pages.read(place.length)

    def _cut_chunk(
        self, data: mmap.mmap, head: ChunkHead, topics: frozenset[str] | None
    ) -> list[Kept]:
        """Return what can be read of the chunk that the file ends in, and state the loss."""
        records = cut_records(data, head)
        found, last_ns = self._sorted(records, topics, cut=True)
        lost_s = max(0, head.end_ns - max(last_ns, head.start_ns)) / NANOSECONDS_PER_SECOND
        n_lost = 'an unknown number of'
        n_read = sum(self._n_messages.values())
        if n_read:
            per_byte = n_read / self._n_bytes
            n_lost = f'{round(per_byte * max(0, head.uncompressed_size - len(records)))}'
        self._end = (
            f'file ends at byte {len(data)} inside a chunk, about {lost_s:.3g} s / {n_lost} '
            'messages of it lost, what followed is unknown'
        )
        return found

    def _record(self, opcode: int, content: bytes, topics: frozenset[str] | None) -> list[Kept]:
        if opcode == CHUNK:
            return self._sorted(uncompress(_parse(Chunk, content)), topics)[0]
        if opcode == MESSAGE_OPCODE:
            return self._sorted(RECORD.pack(opcode, len(content)) + content, topics)[0]
        if opcode in (SCHEMA, CHANNEL):
            self._describe(opcode, content)
        elif opcode == STATISTICS:
            self._indexed = _parse(Statistics, content)
        return []

    def _sorted(
        self, data: bytes, topics: frozenset[str] | None, *, cut: bool = False
    ) -> tuple[list[Kept], int]:
        """Return the messages among records by log time, and the last log time of any topic."""
        found: list[Kept] = []
        kinds: dict[int, tuple[str, str] | None] = {}
        counts: dict[int, int] = {}
        last_ns = 0
        try:
            for opcode, key, log_ns, content in records_of(data):
                if opcode != MESSAGE_OPCODE:
                    self._describe(opcode, content)
                    continue
                if key not in kinds:
                    kinds[key], counts[key] = self._kind_of(key, topics), 0
                counts[key] += 1
                last_ns = max(last_ns, log_ns)
                kind = kinds[key]
                if kind is not None:
                    found.append((log_ns, kind, content))
        except RecordingError:
            if not cut:
                raise
        for key, count in counts.items():
            self._n_messages[key] = self._n_messages.get(key, 0) + count
        self._n_bytes += len(data)
        found.sort(key=itemgetter(0))
        return found, last_ns

    def _kind_of(self, key: int, topics: frozenset[str] | None) -> tuple[str, str] | None:
        """Return topic and type of a channel's messages; None where they are not asked for."""
        channel = self._channels.get(key)
        if channel is None:
            raise RecordingError('message of an undeclared channel', found=key)
        if topics is not None and channel.topic not in topics:
            return None
        schema = self._schemas.get(channel.schema_id)
        return channel.topic, schema.name if schema else ''

    def _describe(self, opcode: int, content: bytes) -> None:
        if opcode == SCHEMA:
            schema = _parse(Schema, content)
            self._schemas.setdefault(schema.id, schema)
        elif opcode == CHANNEL:
            channel = _parse(Channel, content)
            self._channels.setdefault(channel.id, channel)

    def _lost(self, what: str, start: int, stop: int) -> None:
        self._damage.append(f'{what}: {stop - start} bytes at byte {start} not read')

    def _close_accounts(self) -> None:
        read = sum(self._n_messages.values())
        if self._indexed is not None and self._indexed.message_count > read:
            lost = self._indexed.message_count - read
            share = 100.0 * lost / self._indexed.message_count
            self._damage.insert(
                0, f'{read} of {self._indexed.message_count} messages read, {share:.1f} % lost'
            )
        elif self._damage and not self._end:
            self._damage.insert(0, f'{read} messages read')
        if self._end:
            self._damage.append(f'{self._end}; {read} messages read')


def _parse(kind: type[Any], content: bytes) -> Any:
    try:
        return kind.read(_stream(content))
    except PARSE_ERRORS as error:
        raise RecordingError(f'damaged {kind.__name__.lower()} record') from error


def _stream(content: bytes) -> ReadDataStream:
    return ReadDataStream(BytesIO(content))


def _definition(schema: Schema | None) -> str:
    if schema is None or schema.encoding != 'ros2msg':
        return ''
    return bytes(schema.data).decode('utf-8', errors='replace')
