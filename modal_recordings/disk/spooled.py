"""Arrays that memory shall not hold whole: written to a file without a name, and mapped."""

from collections.abc import Iterable
from pathlib import Path
from tempfile import gettempdir, TemporaryFile
from typing import IO

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import RecordingError


def spooled(
    path: Path, pieces: Iterable[NDArray[np.float64]], n_columns: int
) -> NDArray[np.float64]:
    """Return pieces one below the other, as a memory map.

    The file behind it has no name: the operating system takes it back with the array, and also
    when the program is killed.

    Parameters
    ----------
    path : Path
        What is read, for messages.
    pieces : iterable of (n_rows, n_columns) array
        Taken one at a time.
    n_columns : int
        Of all pieces.

    Raises
    ------
    RecordingError
        There is no room for the file.
    """
    n_rows = 0
    with _written(path) as file:
        for piece in pieces:
            _write(path, file, piece)
            n_rows += len(piece)
        if n_rows == 0:
            return np.empty((0, n_columns))
        return np.memmap(file, np.float64, 'r', shape=(n_rows, n_columns))


def _written(path: Path) -> IO[bytes]:
    try:
        # Not buffered: what is mapped must have been written.
        return TemporaryFile(buffering=0)
    except OSError as error:
        raise _no_room(path, error) from error


def _write(path: Path, file: IO[bytes], piece: NDArray[np.float64]) -> None:
    left = memoryview(piece.astype(np.float64, copy=False).tobytes())
    try:
        while left:
            left = left[file.write(left) :]
    except OSError as error:
        raise _no_room(path, error) from error


def _no_room(path: Path, error: OSError) -> RecordingError:
    return RecordingError(
        f'no room to read it: {error.strerror or error}',
        where=path,
        found=gettempdir(),
        advice='set TMPDIR to a folder with room for it',
    )
