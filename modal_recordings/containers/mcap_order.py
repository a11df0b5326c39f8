"""Chunks of an MCAP file that are not in the order of time, put in order by its index.

One who writes topic after topic leaves such a file.

References
----------
.. [1] MCAP file format specification, Chunk Index, https://mcap.dev/spec
"""

from bisect import bisect_left
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from operator import itemgetter
import struct
from typing import NamedTuple

from mcap.opcode import Opcode

from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_recordings.containers.mcap_chunk import records_of
from modal_recordings.messages import Kept

# First and last log time, where the record begins, its length.
INDEXED = struct.Struct('<QQQQ')
OVERLAP_NS = NANOSECONDS_PER_SECOND // 4
"""Chunks of a recorder overlap by less; messages are taken in batches as long as this."""


class ChunkPlace(NamedTuple):
    """Where a chunk's record is, and when its messages were logged.

    Parameters
    ----------
    start_ns, end_ns : int [ns]
        Log time of its first and last message.
    offset, length : int
        First byte of the record and its bytes.
    """

    start_ns: int
    end_ns: int
    offset: int
    length: int


def indexed_chunks(summary: bytes) -> list[ChunkPlace]:
    """Return the chunks of a file in its own order, as the index at its end says.

    Raises
    ------
    RecordingError
        The index is damaged.
    """
    found = [
        ChunkPlace(*INDEXED.unpack_from(content))
        for opcode, _, _, content in records_of(summary)
        if opcode == Opcode.CHUNK_INDEX and len(content) >= INDEXED.size
    ]
    return sorted(found, key=lambda place: place.offset)


def out_of_order(places: Sequence[ChunkPlace]) -> bool:
    """Tell whether any chunk begins well before the end of the one before it."""
    return any(after.start_ns < before.end_ns - OVERLAP_NS for before, after in pairwise(places))


def by_log_time(chunks: Iterable[tuple[int, list[Kept]]]) -> Iterator[list[Kept]]:
    """Yield messages by log time, of chunks that overlap but come by their first log times.

    Parameters
    ----------
    chunks : iterable of (int [ns], list)
        First log time of a chunk, and its messages by log time.
    """
    waiting: list[Kept] = []
    for start_ns, found in chunks:
        # What comes before the first message of this chunk comes before all that follow, too.
        n_due = bisect_left(waiting, start_ns, key=itemgetter(0))
        if n_due:
            yield waiting[:n_due]
            del waiting[:n_due]
        waiting += found
        waiting.sort(key=itemgetter(0))
    if waiting:
        yield waiting
