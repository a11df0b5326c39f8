"""A file that unpacks to more than fits is refused before it is unpacked."""

import numpy as np
import pytest
import zstandard

from modal_core.errors import RecordingError
from modal_recordings.disk.zstd_file import check_unpacked_size, LARGEST_BYTES
from modal_recordings.open_recording import open_recording


def test_a_bomb_is_refused_by_name(tmp_path):
    bomb = tmp_path / 'bag_0.db3.zstd'
    bomb.write_bytes(zstandard.ZstdCompressor().compress(bytes(50_000_000)))
    assert bomb.stat().st_size < 10_000
    with pytest.raises(RecordingError, match=r'bag_0\.db3\.zstd.*unpacks to too much'):
        check_unpacked_size(tmp_path, largest=10_000_000)
    check_unpacked_size(tmp_path, largest=50_000_000)


def test_several_frames_and_files_count_together(tmp_path):
    frame = zstandard.ZstdCompressor().compress(bytes(4_000_000))
    (tmp_path / 'a.zstd').write_bytes(frame * 2)
    (tmp_path / 'b.zstd').write_bytes(frame)
    check_unpacked_size(tmp_path, largest=12_000_000)
    with pytest.raises(RecordingError, match=r'b\.zstd'):
        check_unpacked_size(tmp_path, largest=11_000_000)


def test_the_reader_asks_first(tmp_path, monkeypatch):
    monkeypatch.setattr('modal_recordings.disk.zstd_file.LARGEST_BYTES', 1000)
    noise = np.random.default_rng(1).bytes(5000)
    (tmp_path / 'x_0.db3.zstd').write_bytes(zstandard.ZstdCompressor().compress(noise))
    (tmp_path / 'metadata.yaml').write_text('rosbag2_bagfile_information: {version: 5}\n')
    with pytest.raises(RecordingError, match='unpacks to too much'):
        open_recording(tmp_path)
    assert LARGEST_BYTES > 1e9


def test_junk_is_named(tmp_path):
    (tmp_path / 'c.zstd').write_bytes(b'hello' * 10)
    with pytest.raises(RecordingError, match=r'c\.zstd.*zstd'):
        check_unpacked_size(tmp_path)
