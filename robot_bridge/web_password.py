"""The password of the controller's web services: from a file or the environment, never shown."""

import os
from pathlib import Path

from modal_core.errors import BridgeError

VARIABLE = 'AMA_RWS_PASSWORD'
# What ABB ships every controller with, as its manuals say.
SHIPPED = 'robotics'
LARGEST_BYTES = 4096


def web_password(file: str) -> str:
    """Return the password: first line of the file, else of the environment, else ABB's own.

    Parameters
    ----------
    file : str
        Its path; empty for none.

    Raises
    ------
    BridgeError
        The file cannot be read, or is empty.
    """
    if not file:
        return os.environ.get(VARIABLE, SHIPPED)
    path = Path(file).expanduser()
    try:
        with path.open('rb') as source:
            lines = source.read(LARGEST_BYTES).decode().splitlines()
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, 'strerror', None) or 'not a text'
        raise BridgeError(f'password cannot be read: {reason}', where=path) from error
    if not lines or not lines[0]:
        raise BridgeError('no password in the first line', where=path)
    return lines[0]
