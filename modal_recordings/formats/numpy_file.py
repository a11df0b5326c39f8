"""Archives of NumPy arrays (.npz)."""

from collections.abc import Iterator
import math
from pathlib import Path
import struct
import tokenize
import zipfile
import zlib

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import RecordingError
from modal_recordings.disk import check_size
from modal_recordings.formats.named_arrays import NamedArray, NamedArrays

LARGEST_BYTES = 2_000_000_000
"""Arrays are unpacked into memory."""
HEADERS = {
    (1, 0): np.lib.format.read_array_header_1_0,
    (2, 0): np.lib.format.read_array_header_2_0,
}
ENDING = '.npy'


def read(path: Path) -> NamedArrays:
    """Return the arrays of a .npz file; what is pickled is left out.

    Raises
    ------
    RecordingError
        Damaged, truncated, or too large for memory.
    """
    arrays, numbers, texts = [], {}, {}
    try:
        with zipfile.ZipFile(path) as archive:
            unpacked = sum(entry.file_size for entry in archive.infolist())
            check_size(path, LARGEST_BYTES, unpacked, 'save the samples as .npy')
            for name, value in _values(archive):
                if value.dtype.kind in 'fiu' and value.size > 1:
                    arrays.append(NamedArray(name, value))
                elif value.dtype.kind in 'fiu' and value.size == 1:
                    numbers[name] = float(value.reshape(-1)[0])
                elif value.dtype.kind == 'U' and value.size == 1:
                    texts[name] = str(value.reshape(-1)[0])
    except (zipfile.BadZipFile, zlib.error, ValueError, OSError, EOFError, LookupError,
            SyntaxError, NotImplementedError, RuntimeError, OverflowError, TypeError,
            MemoryError, struct.error, tokenize.TokenError) as error:  # fmt: skip
        raise RecordingError(
            'damaged or truncated file of NumPy', where=path, found=str(error) or 'no end'
        ) from error
    return NamedArrays(tuple(arrays), numbers, texts=texts)


def _values(archive: zipfile.ZipFile) -> Iterator[tuple[str, NDArray[np.generic]]]:
    """Yield arrays by name, none of which claims to be larger than its part of the file."""
    for entry in archive.infolist():
        if not entry.filename.endswith(ENDING):
            continue
        with archive.open(entry) as file:
            version = np.lib.format.read_magic(file)
            if version not in HEADERS:
                raise ValueError(f'{entry.filename}: version {version}')
            shape, _, dtype = HEADERS[version](file)
        if dtype.hasobject:
            continue
        if math.prod(shape) * dtype.itemsize > entry.file_size:
            raise ValueError(f'{entry.filename} ends early')
        with archive.open(entry) as file:
            yield (
                entry.filename.removesuffix(ENDING),
                np.lib.format.read_array(file, allow_pickle=False),
            )
