"""The ending of a name says which kind of file is written, whole or not at all."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TypeVar

from modal_core.atomic_file import atomic_path
from modal_core.errors import SettingsError

Content = TypeVar('Content')


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
    suffix = path.suffix.lower()
    if suffix not in writers:
        raise SettingsError(
            'unknown kind of file',
            where=path,
            found=suffix or 'no ending',
            expected=', '.join(writers),
        )
    with atomic_path(path) as temporary:
        writers[suffix](temporary, content)
