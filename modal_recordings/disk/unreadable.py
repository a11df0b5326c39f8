"""Why a file cannot be opened, found and expected, from its own first bytes.

References
----------
.. [1] NumPy .npy format, https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html
.. [2] ROS bag format 2.0, http://wiki.ros.org/Bags/Format/2.0
.. [3] SQLite database file format, section 1.3, https://www.sqlite.org/fileformat.html
"""

import math
from pathlib import Path
import re
import struct

import numpy as np

from modal_core.errors import RecordingError

NPY_MAGIC = b'\x93NUMPY'
BAG_MAGIC = b'#ROSBAG V2.0\n'
SQLITE_MAGIC = b'SQLite format 3\x00'
HEAD_BYTES = 4096


def unreadable_npy(path: Path) -> RecordingError:
    """Return what is wrong with a .npy file that could not be mapped."""
    try:
        size = path.stat().st_size
        with path.open('rb') as file:
            start = file.read(len(NPY_MAGIC))
            if start != NPY_MAGIC:
                return _not('a .npy file', path, NPY_MAGIC)
            file.seek(0)
            version = np.lib.format.read_magic(file)
            read = np.lib.format.read_array_header_1_0
            if version != (1, 0):
                read = np.lib.format.read_array_header_2_0
            shape, column_major, dtype = read(file)
            n_bytes = size - file.tell()
    except OSError as error:
        return RecordingError(f'cannot be read: {error.strerror}', where=path)
    except (ValueError, EOFError, SyntaxError, OverflowError, MemoryError):
        return RecordingError('damaged .npy header', where=path, expected='shape and type')
    if dtype.kind not in 'fiu':
        return RecordingError(
            'not real numbers',
            where=path,
            found='Python objects' if dtype.hasobject else dtype,
            expected='floats or integers',
        )
    if n_bytes >= dtype.itemsize * math.prod(shape):
        return RecordingError('cannot be mapped into memory', where=path, found=f'shape {shape}')
    row_bytes = dtype.itemsize * math.prod(shape[1:])
    if column_major or len(shape) not in (1, 2) or not row_bytes:
        expected = f'{dtype.itemsize * math.prod(shape)} bytes'
        return RecordingError('truncated', where=path, found=f'{n_bytes} bytes', expected=expected)
    return RecordingError(
        'truncated',
        where=path,
        found=f'{n_bytes // row_bytes} whole rows',
        expected=f'{shape[0]} rows',
    )


def unreadable_bag(path: Path) -> RecordingError | None:
    """Return what is wrong with a ROS 1 bag that could not be opened; None when it is unclear."""
    size, head = _start(path)
    if not head.startswith(BAG_MAGIC):
        return _not('a ROS 1 bag: wrong magic', path, BAG_MAGIC)
    field = re.search(rb'index_pos=(.{8})', head, re.DOTALL)
    index = struct.unpack('<Q', field.group(1))[0] if field else 0
    if not index:
        return RecordingError(
            'no index: the recorder was stopped hard',
            where=path,
            advice='rebuild it with: rosbag reindex',
        )
    if index >= size:
        return RecordingError(
            'truncated: its index is lost',
            where=path,
            found=f'{size} bytes',
            expected=f'more than {index} bytes',
            advice='rebuild it with: rosbag reindex',
        )
    return None


def unreadable_database(path: Path) -> RecordingError | None:
    """Return what is wrong with a .db3 file that could not be opened; None when it is unclear."""
    size, head = _start(path)
    if not head.startswith(SQLITE_MAGIC):
        return _not('a SQLite database', path, SQLITE_MAGIC)
    if len(head) < 100:
        return RecordingError('truncated database', where=path, found=f'{size} bytes')
    (page,) = struct.unpack_from('>H', head, 16)
    (n_pages,) = struct.unpack_from('>I', head, 28)
    expected = (65536 if page == 1 else page) * n_pages
    if size < expected:
        return RecordingError(
            'truncated database',
            where=path,
            found=f'{size} bytes',
            expected=f'{expected} bytes',
            advice='recover what it holds with: sqlite3 <file> .recover',
        )
    return None


def _start(path: Path) -> tuple[int, bytes]:
    try:
        with path.open('rb') as file:
            return path.stat().st_size, file.read(HEAD_BYTES)
    except OSError as error:
        raise RecordingError(f'cannot be read: {error.strerror}', where=path) from error


def _not(what: str, path: Path, expected: bytes) -> RecordingError:
    # None of its bytes: a link may lead to a file that is nobody's business.
    return RecordingError(
        f'not {what}', where=path, found='other first bytes', expected=repr(expected)
    )
