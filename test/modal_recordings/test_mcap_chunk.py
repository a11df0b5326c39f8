"""The content of one chunk: no more of it than it declares."""

import struct
import tracemalloc

import lz4.frame
from mcap.records import Chunk
from mcap.writer import Writer
import pytest
import zstandard

from modal_core.errors import RecordingError
from modal_recordings import open_recording
from modal_recordings.containers.mcap_chunk import uncompress

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


def test_a_recording_without_topics_tells_what_of_it_is_damaged(tmp_path):
    path = tmp_path / 'a.mcap'
    content = zstd(BOMB[:70_000])
    with path.open('wb') as file:
        writer = Writer(file)
        writer.start()
        writer.finish()
    whole = path.read_bytes()
    head = struct.pack('<QQQI', 0, 1, 1000, 0) + struct.pack('<I4sQ', 4, b'zstd', len(content))
    chunk = struct.pack('<BQ', 6, len(head) + len(content)) + head + content
    at = whole.index(b'\x0f' + struct.pack('<Q', 4))  # the end of the data
    path.write_bytes(whole[:at] + chunk + whole[at:])
    with pytest.raises(RecordingError, match=r'no usable topic \(found no topics; .*larger than'):
        open_recording(path)
