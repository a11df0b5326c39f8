"""Libraries that only some files need."""

from importlib import import_module
from pathlib import Path
from typing import Any

from modal_core.errors import RecordingError

EXTRAS = {'h5py': 'hdf', 'nptdms': 'tdms', 'asammdf': 'mdf'}
"""Library to the extra of this package that installs it."""


def optional_library(name: str, path: Path) -> Any:
    """Import a library.

    Raises
    ------
    RecordingError
        It is not installed; says how to install it.
    """
    try:
        return import_module(name)
    except ImportError as error:
        raise RecordingError(
            f'{name} is needed to read it',
            where=path,
            advice=f"pip install 'autonomous_modal_analysis[{EXTRAS[name]}]'",
        ) from error
