"""Where a path leads, also one that leads in a circle."""

import os
from pathlib import Path


def real_path(path: Path) -> Path:
    """Return a path without links, absolute; nothing need be there.

    ``Path.resolve`` ends in a RuntimeError where links lead in a circle (Python before 3.13);
    who opens what is returned here is told so.

    Raises
    ------
    ValueError
        There is a null character in it.
    """
    return Path(os.path.realpath(path))
