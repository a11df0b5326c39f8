"""Read a whole file that may come from anywhere: regular, size-capped, one clear error."""

from pathlib import Path
import stat

from modal_core.errors import SettingsError


def read_bytes(path: Path, largest: int) -> bytes:
    """Return what a file holds.

    Parameters
    ----------
    path : Path
        The file.
    largest : int
        Bytes it may have; no more are ever read, also of a file that grows.

    Raises
    ------
    SettingsError
        The file is missing, no regular one (a pipe would wait for ever), or too large.
    """
    try:
        # Before opening: to open a pipe is to wait for its other end.
        if not stat.S_ISREG(path.stat().st_mode):
            raise SettingsError('not a regular file', where=path)
        with path.open('rb') as file:
            data = file.read(largest + 1)
    except (OSError, ValueError) as error:
        reason = getattr(error, 'strerror', None) or error
        raise SettingsError(f'cannot be read: {reason}', where=path) from error
    if len(data) > largest:
        raise SettingsError(
            'file too large',
            where=path,
            found=f'more than {largest} bytes',
            expected=f'<= {largest} bytes',
        )
    return data


def read_text(path: Path, largest: int) -> str:
    """Return the text of a file in UTF-8.

    Raises
    ------
    SettingsError
        As :func:`read_bytes`, or it is not UTF-8.
    """
    try:
        return read_bytes(path, largest).decode('utf-8-sig')
    except UnicodeDecodeError as error:
        # The position, not the byte: a link may lead to a file that is nobody's business.
        raise SettingsError(
            'not a text file', where=path, found=f'no UTF-8 at byte {error.start}'
        ) from error
