"""Read JSON that may come from anywhere: size-capped, of bounded depth, one clear error."""

import json
from pathlib import Path
from typing import Any

from modal_core.errors import SettingsError
from modal_core.files.small_file import read_text


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
        The file is missing, too large, not JSON, nested too deeply, or holds a whole number beyond
        floating-point numbers.
    """
    text = read_text(path, largest)
    try:
        return json.loads(text, parse_int=_whole)
    except RecursionError as error:
        raise SettingsError('nested too deeply', where=path) from error
    except OverflowError as error:
        raise SettingsError('number too large', where=path) from error
    except ValueError as error:
        line = getattr(error, 'lineno', None)
        raise SettingsError('not JSON', where=f'{path}, line {line}' if line else path) from error


def _whole(text: str) -> int:
    number = int(text)
    float(number)
    return number
