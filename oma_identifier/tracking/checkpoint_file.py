"""The file that keeps an identifier's memory, for one identifier at a time."""

import fcntl
import json
import os
from pathlib import Path

from modal_core.errors import SettingsError
from modal_core.files.atomic_file import atomic_path, write_text
from modal_core.files.json_file import load_json
from modal_core.files.small_file import read_bytes
from oma_identifier.tracking.tracking import ModeTracker

LARGEST_BYTES = 50_000_000


class CheckpointFile:
    """Ids of modes and the last result, kept from one start to the next.

    Parameters
    ----------
    path : Path
        The ids; the last result lies beside it as ``.last``, and ``.lock`` says that somebody
        writes them.  The kernel lets go of that lock when its process ends, however it ends.

    Raises
    ------
    SettingsError
        Another identifier writes the same file.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.last = path.with_name(f'{path.name}.last')
        self._lock = self._locked(path.with_name(f'{path.name}.lock'))

    def _locked(self, path: Path) -> int | None:
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            lock = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW, 0o644)
        except OSError:
            # Where no file can be made none can be spoilt: writing will say so.
            return None
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            os.close(lock)
            raise SettingsError(
                'used by another identifier',
                where=f'checkpoint_file {self.path}',
                advice='give every identifier a file of its own',
            ) from error
        return lock

    def tracker(self) -> ModeTracker | None:
        """Return the memory of the identifier before; None where there was none.

        Raises
        ------
        SettingsError
            The file is none of ours.
        """
        if not self.path.exists():
            return None
        return ModeTracker.from_json(load_json(self.path, LARGEST_BYTES))

    def last_result(self) -> bytes | None:
        """Return the last result, serialised; None where there is none.

        Raises
        ------
        SettingsError
            It cannot be read.
        """
        return read_bytes(self.last, LARGEST_BYTES) if self.last.exists() else None

    def save(self, tracker: ModeTracker, result: bytes) -> None:
        """Write both, each whole or not at all.

        Raises
        ------
        OSError
            They cannot be written.
        """
        write_text(self.path, json.dumps(tracker.to_json()))
        with atomic_path(self.last) as temporary:
            temporary.write_bytes(result)

    def close(self) -> None:
        """Let another identifier have the file."""
        if self._lock is not None:
            os.close(self._lock)
            self._lock = None
