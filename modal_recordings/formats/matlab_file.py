"""MATLAB files: version 5 to 7 (SciPy) and 7.3, which is HDF5."""

from collections.abc import Iterator, Mapping
from pathlib import Path
import zlib

import numpy as np
from scipy.io import loadmat
from scipy.io.matlab import MatReadError

from modal_core.errors import RecordingError
from modal_recordings.disk import check_size
from modal_recordings.formats import hdf_file
from modal_recordings.formats.named_arrays import NamedArray, NamedArrays

HDF_MAGIC = b'\x89HDF\r\n\x1a\n'
HDF_OFFSET = 512
"""MATLAB 7.3 writes its own header before the HDF5 file."""
LARGEST_BYTES = 2_000_000_000
"""SciPy reads a file whole."""
DEEPEST = 8


def read(path: Path) -> NamedArrays:
    """Return the arrays of a .mat file; fields of structures are called ``name.field``.

    Raises
    ------
    RecordingError
        Damaged, truncated, or too large for memory.
    """
    with path.open('rb') as file:
        head = file.read(HDF_OFFSET + len(HDF_MAGIC))
    if head.startswith(HDF_MAGIC) or head[HDF_OFFSET:] == HDF_MAGIC:
        return hdf_file.read(path, matlab=True)
    check_size(path, LARGEST_BYTES, advice="save it with '-v7.3'")
    try:
        content = loadmat(path, simplify_cells=True)
    except (MatReadError, zlib.error, ValueError, TypeError, KeyError, OSError, EOFError,
            IndexError, NotImplementedError, MemoryError) as error:  # fmt: skip
        raise RecordingError(
            'damaged or truncated MATLAB file', where=path, found=str(error) or 'no end'
        ) from error
    arrays, numbers, texts = [], {}, {}
    for name, value in _flat({k: v for k, v in content.items() if not k.startswith('__')}):
        if isinstance(value, np.ndarray) and value.dtype.kind in 'fiu' and value.size > 1:
            arrays.append(NamedArray(name, value, between_groups='.'))
        elif isinstance(value, (int, float, np.number)) and not isinstance(value, bool):
            numbers[name] = float(value)
        elif isinstance(value, str):
            texts[name] = value
    return NamedArrays(tuple(arrays), numbers, texts=texts)


def _flat(
    content: Mapping[str, object], before: str = '', depth: int = 0
) -> Iterator[tuple[str, object]]:
    for name, value in content.items():
        if isinstance(value, Mapping) and depth < DEEPEST:
            yield from _flat(value, f'{before}{name}.', depth + 1)
        else:
            yield f'{before}{name}', value
