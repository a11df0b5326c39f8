"""Attachments of an MCAP file, read by their bytes and within bounds.

References
----------
.. [1] MCAP file format specification, https://mcap.dev/spec
"""

from collections.abc import Iterable, Iterator
import mmap
import struct
import zlib

from mcap.opcode import Opcode

from modal_core.errors import RecordingError
from modal_recordings.containers.mcap_chunk import CHUNK, MESSAGE_OPCODE, RECORD, records_of
from modal_recordings.messages import Attachment, LARGEST_BYTES

MOST, ALL_BYTES = 100, 20_000_000
"""Attachments that are looked at, and bytes that are read of all of them."""
LONGEST_NAME = 255
"""Bytes of a file's name (POSIX), and of a media type (RFC 6838, section 4.2)."""
NUMBER, SIZE, TIMES = struct.Struct('<I'), struct.Struct('<Q'), struct.Struct('<QQ')


def indexed_places(summary: bytes) -> list[int]:
    """Return where the attachments of a file begin, as the index at its end says.

    Raises
    ------
    RecordingError
        The index is damaged.
    """
    return [
        SIZE.unpack_from(content)[0]
        for opcode, _, _, content in records_of(summary)
        if opcode == Opcode.ATTACHMENT_INDEX and len(content) >= SIZE.size
    ]


def leading_places(data: mmap.mmap, position: int) -> Iterator[int]:
    """Yield where attachments begin that stand before the first message, from a record on.

    Those of the first 20 MB: a damaged file may be full of empty records.
    """
    end = min(len(data), ALL_BYTES)
    while position + RECORD.size <= end:
        opcode, length = RECORD.unpack_from(data, position)
        if opcode in (CHUNK, MESSAGE_OPCODE):
            return
        if opcode == Opcode.ATTACHMENT:
            yield position
        position += RECORD.size + length


def read_attachments(data: mmap.mmap, places: Iterable[int]) -> tuple[Attachment, ...]:
    """Return the attachments whose records begin at these bytes, the first hundred.

    What is damaged or too large is named and not read.
    """
    found: list[Attachment] = []
    room = ALL_BYTES
    for position, _ in zip(places, range(MOST), strict=False):
        try:
            found.append(_attachment(data, position, room))
        except (RecordingError, struct.error):
            found.append(Attachment('', '', 0, problem=f'damaged at byte {position}'))
        room -= len(found[-1].data)
    return tuple(found)


def _attachment(data: mmap.mmap, position: int, room: int) -> Attachment:
    start = position + RECORD.size
    opcode, length = RECORD.unpack_from(data, position) if start <= len(data) else (0, 0)
    stop = start + length
    if opcode != Opcode.ATTACHMENT or stop > len(data):
        raise RecordingError('no attachment there')
    name, at = _text(data, start + TIMES.size)
    media_type, at = _text(data, at)
    (n_bytes,) = SIZE.unpack_from(data, at)
    at += SIZE.size
    if at + n_bytes + NUMBER.size != stop:
        raise RecordingError('attachment of another length')
    if n_bytes > min(LARGEST_BYTES, room):
        return Attachment(name, media_type, n_bytes, problem='too large')
    (checksum,) = NUMBER.unpack_from(data, at + n_bytes)
    # Zero: the writer made none.
    if checksum and zlib.crc32(data[start : at + n_bytes]) != checksum:
        return Attachment(name, media_type, n_bytes, problem='with a wrong checksum')
    return Attachment(name, media_type, n_bytes, data[at : at + n_bytes])


def _text(data: mmap.mmap, at: int) -> tuple[str, int]:
    """Return a text with its length before it, and where it ends."""
    (length,) = NUMBER.unpack_from(data, at)
    if length > LONGEST_NAME:
        raise RecordingError('name too long')
    at += NUMBER.size
    return data[at : at + length].decode('utf-8', errors='replace'), at + length
