"""Read JSON that may come from anywhere: size-capped, of bounded depth, one clear error."""

import json
from pathlib import Path
from typing import Any

from modal_core.errors import SettingsError
from modal_core.small_file import read_text


def load_json(path: Path, largest: int) -> Any:
    """Return what a JSON file holds.

    Parameters
    ----------
    path : Path
        The file.
    largest : int
        Bytes it may have.

    Raises
    ------
    SettingsError
        The file is missing, too large, not JSON, or nested too deeply.
    """
    text = read_text(path, largest)
    try:
        return json.loads(text)
    except RecursionError as error:
        raise SettingsError('nested too deeply', where=path) from error
    except ValueError as error:
        line = getattr(error, 'lineno', None)
        raise SettingsError('not JSON', where=f'{path}, line {line}' if line else path) from error
