"""The ending of a name says which kind of file is written, whole or not at all."""

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TypeVar

from modal_core.errors import SettingsError
from modal_core.files.atomic_file import atomic_path

Content = TypeVar('Content')
KNOWN = ('.uff', '.unv', '.mat', '.nc', '.parquet', '.csv')


def write_by_ending(
    path: Path, writers: Mapping[str, Callable[[Path, Content], None]], content: Content
) -> None:
    """Write content by the writer of the ending.

    Parameters
    ----------
    path : path
        Its ending in any case.
    writers : mapping of str to callable
        By ending, ``.uff``.
    content : object
        What they write.

    Raises
    ------
    SettingsError
        No writer for the ending.
    OSError
        It cannot be written.
    """
    check_endings([path], tuple(writers))
    with atomic_path(path) as temporary:
        writers[ending_of(path)](temporary, content)


def check_endings(files: Iterable[Path], endings: tuple[str, ...]) -> None:
    """Refuse files whose ending means nothing here, before the work whose result they shall hold.

    Parameters
    ----------
    files : iterable of path
        What shall be written; a name that is an ending alone, ``.uff``, counts as that.
    endings : tuple of str
        What can be written.

    Raises
    ------
    SettingsError
        Another ending.
    """
    for file in files:
        suffix = ending_of(file)
        if suffix not in endings:
            what = 'a kind of file that cannot hold this result' if suffix in KNOWN else ''
            raise SettingsError(
                what or 'unknown kind of file',
                where=file,
                found=suffix or 'no ending',
                expected=', '.join(endings),
            )


def ending_of(file: Path) -> str:
    """Return the ending of a name in small letters, or the name where it is an ending alone."""
    return (file.suffix or (file.name if file.name.startswith('.') else '')).lower()
