"""The content of one chunk: no more of it than it declares."""

import tracemalloc

import lz4.frame
from mcap.records import Chunk
import pytest
import zstandard

from modal_core.errors import RecordingError
from modal_recordings.mcap_chunk import uncompress

BOMB = bytes(200_000_000)


def zstd(content):
    return zstandard.ZstdCompressor().compress(content)


@pytest.mark.parametrize(('name', 'compress'), [('zstd', zstd), ('lz4', lz4.frame.compress)])
def test_a_chunk_that_unpacks_to_more_than_it_declares_costs_no_memory(name, compress):
    packed = compress(BOMB)
    chunk = Chunk(name, packed, 1, 0, 0, 1000)
    tracemalloc.start()
    with pytest.raises(RecordingError, match='chunk'):
        uncompress(chunk)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 5_000_000
    whole = Chunk(name, compress(BOMB[:70_000]), 1, 0, 0, 70_000)
    assert uncompress(whole) == BOMB[:70_000]
