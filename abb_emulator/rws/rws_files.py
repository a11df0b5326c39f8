"""The files of the emulated controller, held in memory and nowhere else."""

from dataclasses import dataclass
import re
import time

from abb_emulator.rapid import LARGEST_BYTES
from abb_emulator.rws.rws_refusal import BAD_REQUEST, NO_PATH, RwsRefusalError, unknown

# Bounds the memory, 32 times LARGEST_BYTES; a plan is one file.
MOST_FILES = 32
HOME, TEMP = 'HOME', 'TEMP'
VOLUMES = {
    'home': HOME, 'temp': TEMP, 'ramdisk': TEMP,
    'hd0a': HOME, 'ctrl': HOME,
}  # fmt: skip
_PATH = re.compile(r'/?\$?(\w+):?(?:/(.*))?', re.ASCII)
_NAME = re.compile(r'[A-Za-z0-9_][A-Za-z0-9_.-]{0,63}')


@dataclass(frozen=True, slots=True)
class StoredFile:
    """One file.

    Parameters
    ----------
    data : bytes
        Its content.
    changed_s : float [s]
        When it was written, since 1970.
    """

    data: bytes
    changed_s: float


class Files:
    """Volumes without folders: ``$HOME``, and ``$TEMP``, which is ``$RAMDISK`` too."""

    def __init__(self) -> None:
        self._files: dict[tuple[str, str], StoredFile] = {}

    def store(self, path: str, data: bytes) -> bool:
        """Keep a file; True when it is new.

        Raises
        ------
        RwsRefusalError
            Not a plain name in a volume, too large, or too many of them.
        """
        place = self._place(path)
        new = place not in self._files
        if len(data) > LARGEST_BYTES or (new and len(self._files) >= MOST_FILES):
            raise RwsRefusalError('no room', found=path[:80])
        self._files[place] = StoredFile(data, time.time())
        return new

    def read(self, path: str) -> bytes:
        """Return a file's content.

        Raises
        ------
        RwsRefusalError
            There is none.
        """
        file = self._files.get(self._place(path))
        if file is None:
            raise unknown('Path', NO_PATH)
        return file.data

    def remove(self, path: str) -> None:
        """Delete a file.

        Raises
        ------
        RwsRefusalError
            There is none.
        """
        self.read(path)
        del self._files[self._place(path)]

    def listed(self, path: str) -> dict[str, StoredFile] | None:
        """Return the files of a volume by name; None when the path names no volume."""
        found = _PATH.fullmatch(path)
        volume = VOLUMES.get(found[1].lower()) if found and not found[2] else None
        if volume is None:
            return None
        return {name: file for (of, name), file in sorted(self._files.items()) if of == volume}

    def _place(self, path: str) -> tuple[str, str]:
        found = _PATH.fullmatch(path)
        volume = VOLUMES.get(found[1].lower()) if found else None
        name = (found[2] or '') if found else ''
        if volume is None or not _NAME.fullmatch(name):
            raise RwsRefusalError('Path does not exist', BAD_REQUEST, NO_PATH, path[:80])
        return volume, name
