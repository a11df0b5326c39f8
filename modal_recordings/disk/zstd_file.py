"""Guard against compressed files that unpack to more than there is room for."""

from pathlib import Path
import shutil
import tempfile

import zstandard

from modal_core.errors import RecordingError

LARGEST_BYTES = 64_000_000_000
SHARE_OF_FREE = 0.8
"""Of the free space where files are unpacked to."""
PIECE_BYTES = 1 << 20


def check_unpacked_size(path: Path, largest: int | None = None) -> None:
    """Refuse zstd files of a rosbag2 folder that unpack to too much.

    Parameters
    ----------
    path : Path
        Folder, or one file.
    largest : int or None
        Bytes that all files together may unpack to; None: what there is room for.

    Raises
    ------
    RecordingError
        Naming the file and the limit.
    """
    files = [path] if path.is_file() else sorted(path.iterdir()) if path.is_dir() else []
    packed = [file for file in files if file.suffix in ('.zst', '.zstd')]
    if not packed:
        return
    if largest is None:
        free = shutil.disk_usage(tempfile.gettempdir()).free
        largest = min(LARGEST_BYTES, int(SHARE_OF_FREE * free))
    total = 0
    for file in packed:
        total += _unpacked_bytes(file, largest - total)
        if total > largest:
            raise RecordingError(
                'unpacks to too much',
                where=file,
                found=f'more than {largest:,} bytes from {file.stat().st_size:,}',
                expected='what fits into the temporary folder',
            )


def _unpacked_bytes(file: Path, most: int) -> int:
    """Return the unpacked size, counted no further than just past ``most``."""
    count = 0
    try:
        with file.open('rb') as source:
            reader = zstandard.ZstdDecompressor().stream_reader(source, read_across_frames=True)
            while count <= most and (piece := reader.read(PIECE_BYTES)):
                count += len(piece)
    except zstandard.ZstdError as error:
        raise RecordingError(f'not a readable zstd file: {error}', where=file) from error
    return count
