"""The records inside one MCAP chunk, read by their bytes: an order of magnitude quicker."""

from collections.abc import Iterator
import mmap
import re
import struct
from typing import NamedTuple
import zlib

import lz4.frame  # type: ignore[import-untyped]
from mcap.records import Chunk
import zstandard

from modal_core.errors import RecordingError

RECORD = struct.Struct('<BQ')
# Of a message: opcode, length, channel, sequence, log time, publish time.
MESSAGE = struct.Struct('<BQHIQQ')
# Of a chunk: first and last log time, uncompressed size, checksum, length of a compression name.
HEAD = struct.Struct('<QQQII')
SIZE = struct.Struct('<Q')
SCHEMA, CHANNEL, MESSAGE_OPCODE, CHUNK = 3, 4, 5, 6
COMPRESSIONS = ('', 'lz4', 'zstd')
# A chunk record: opcode, length, two times, size, checksum, then the name of its compression.
CHUNK_START = re.compile(
    rb'\x06.{6}\x00\x00.{28}(?:\x00\x00\x00\x00|\x03\x00\x00\x00lz4|\x04\x00\x00\x00zstd)',
    re.DOTALL,
)
LARGEST_CHUNK_BYTES = 512_000_000


class ChunkHead(NamedTuple):
    """What a chunk says of itself before its records.

    Parameters
    ----------
    start_ns, end_ns : int [ns]
        Log time of its first and last message.
    uncompressed_size : int
        Bytes of its records.
    compression : str
        Name, empty for none.
    records_offset : int
        Where the records begin in the file.
    records_size : int
        Bytes of the records in the file.
    length : int
        Length the record of the chunk must have.
    """

    start_ns: int
    end_ns: int
    uncompressed_size: int
    compression: str
    records_offset: int
    records_size: int
    length: int


def chunk_head(data: mmap.mmap, start: int) -> ChunkHead | None:
    """Return the head of the chunk whose content begins at a byte; None when it makes no sense.

    The fields must agree with one another, which bytes that merely look like a chunk do not.
    """
    if start + HEAD.size > len(data):
        return None
    start_ns, end_ns, uncompressed_size, _, n_name = HEAD.unpack_from(data, start)
    name = start + HEAD.size
    offset = name + n_name + SIZE.size
    if n_name > 4 or offset > len(data) or end_ns < start_ns:
        return None
    compression = data[name : name + n_name].decode('ascii', errors='replace')
    (records_size,) = SIZE.unpack_from(data, name + n_name)
    if compression not in COMPRESSIONS or uncompressed_size > LARGEST_CHUNK_BYTES:
        return None
    if not compression and records_size != uncompressed_size:
        return None
    return ChunkHead(
        start_ns,
        end_ns,
        uncompressed_size,
        compression,
        offset,
        records_size,
        offset - start + records_size,
    )


def next_chunk(data: mmap.mmap, start: int) -> int | None:
    """Return where the next chunk record with a consistent head begins, or None.

    The last one may run past the end of the file.
    """
    for match in CHUNK_START.finditer(data, start):
        _, length = RECORD.unpack_from(data, match.start())
        head = chunk_head(data, match.start() + RECORD.size)
        if head is not None and head.length == length:
            return match.start()
    return None


def cut_records(data: mmap.mmap, head: ChunkHead) -> bytes:
    """Return the records of a chunk that the file ends in, as far as they can be had.

    Notes
    -----
    Nothing checks them: the checksum is of the whole chunk.
    """
    stored = data[head.records_offset : head.records_offset + head.records_size]
    try:
        return _expanded(head.compression, stored, head.uncompressed_size)
    except RecordingError:
        return b''


def uncompress(chunk: Chunk) -> bytes:
    """Return the content of a chunk, checked against its size and checksum.

    Raises
    ------
    RecordingError
        Unknown compression, broken data, a size other than declared, a wrong checksum.
    """
    size = chunk.uncompressed_size
    if size > LARGEST_CHUNK_BYTES:
        raise RecordingError(
            'chunk too large', found=f'{size} bytes', expected=f'at most {LARGEST_CHUNK_BYTES}'
        )
    data = _expanded(chunk.compression, chunk.data, size)
    if len(data) != size:
        raise RecordingError('chunk of wrong size', found=len(data), expected=size)
    if chunk.uncompressed_crc and zlib.crc32(data) != chunk.uncompressed_crc:
        raise RecordingError('chunk with a wrong checksum')
    return data


def records_of(data: bytes) -> Iterator[tuple[int, int, int, bytes]]:
    """Yield the records in uncompressed chunk data: opcode, channel, log time [ns], data.

    The data are the payload of a message, and the content of another record, whose channel and
    time are 0.  A recording has millions of them: nothing is made of any that is not needed.

    Raises
    ------
    RecordingError
        A record runs past the end.
    """
    position, end, unpack = 0, len(data), MESSAGE.unpack_from
    # No record of any kind reaches past the end of a message that begins here.
    last = end - MESSAGE.size
    while position < end:
        if position <= last and data[position] == MESSAGE_OPCODE:
            opcode, length, channel_id, _, log_time, _ = unpack(data, position)
            start, position = position + MESSAGE.size, position + RECORD.size + length
            if position > end or position < start:
                raise RecordingError('record cut short in a chunk', found=f'{length} bytes')
            yield opcode, channel_id, log_time, data[start:position]
            continue
        if position + RECORD.size > end:
            raise RecordingError('record cut short in a chunk', found=f'{end - position} bytes')
        opcode, length = RECORD.unpack_from(data, position)
        start = position + RECORD.size
        position = start + length
        if position > end or opcode == MESSAGE_OPCODE:
            raise RecordingError('record cut short in a chunk', found=f'{length} bytes')
        yield opcode, 0, 0, data[start:position]


def _expanded(compression: str, stored: bytes, size: int) -> bytes:
    """Return what the bytes of a chunk decompress to; less than its size where they are cut."""
    try:
        if compression == 'zstd':
            # No more of it than declared: a few kilobytes may unpack to gigabytes.
            source = zstandard.ZstdDecompressor().stream_reader(stored)
            data = bytes(source.read(size + 1))
            if len(data) > size:
                raise RecordingError('chunk larger than declared', expected=size)
            return data
        if compression == 'lz4':
            decompressor = lz4.frame.LZ4FrameDecompressor()
            return bytes(decompressor.decompress(stored, max_length=size + 1))
    except (zstandard.ZstdError, RuntimeError, EOFError, MemoryError) as error:
        raise RecordingError('chunk cannot be decompressed') from error
    if compression:
        raise RecordingError('unknown compression', found=repr(compression[:20]))
    return bytes(stored)
