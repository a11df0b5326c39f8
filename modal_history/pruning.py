"""Makes a history smaller: what is old goes, and the file gives back the room."""

from dataclasses import dataclass
from pathlib import Path

from modal_history.history_file import HistoryFile

OLD = 'IN (SELECT id FROM window WHERE end_ns < ?)'


@dataclass(frozen=True, slots=True)
class Pruned:
    """What went.

    Parameters
    ----------
    n_windows, n_shapes : int
        Windows, and windows whose shapes went.
    bytes_before, bytes_after : int
        Size of the file.
    """

    n_windows: int
    n_shapes: int
    bytes_before: int
    bytes_after: int


def prune(path: str | Path, before_ns: int | None = None, only_shapes: bool = False) -> Pruned:
    """Remove windows, or their shapes alone, and compact the file; ids of modes stay.

    Parameters
    ----------
    path : path
        The history.
    before_ns : int [ns] or None
        Windows that end before go; None: compact only.
    only_shapes : bool
        Keep the windows' numbers.

    Raises
    ------
    HistoryError
        It cannot be written, or is damaged; then nothing was removed.
    """
    path = Path(path)
    # Opened to read first: a file that is not there must not be made, nor a damaged one touched.
    looked = HistoryFile(path)
    try:
        looked.check()
    finally:
        looked.close()
    before, file = path.stat().st_size, HistoryFile(path, write=True)
    try:
        windows = shapes = 0
        if before_ns is not None:
            with file.change():
                shapes = _delete(file, f'shape WHERE window {OLD}', before_ns)
                if not only_shapes:
                    _delete(file, f'mode WHERE window {OLD}', before_ns)
                    windows = _delete(file, 'window WHERE end_ns < ?', before_ns)
                    _delete(file, 'run WHERE id NOT IN (SELECT run FROM window)')
        with file.told():
            file.rows.execute('VACUUM')
    finally:
        file.close()
    return Pruned(windows, shapes, before, path.stat().st_size)


def _delete(file: HistoryFile, words: str, *values: int) -> int:
    return file.rows.execute(f'DELETE FROM {words}', values).rowcount
