"""Which file of this folder reads which kind; each has a function ``read(path)``.

A reader is imported with the first file of its kind.
"""

from importlib import import_module
from pathlib import Path

from modal_recordings.formats.named_arrays import NamedArrays

READERS = {
    '.uff': 'universal_file',
    '.unv': 'universal_file',
    '.npz': 'numpy_file',
    '.mat': 'matlab_file',
    '.h5': 'hdf_file',
    '.hdf5': 'hdf_file',
    '.nc': 'netcdf_file',
    '.wav': 'wav_file',
    '.tdms': 'tdms_file',
    '.lvm': 'lvm_file',
    '.mf4': 'mdf_file',
    '.mdf': 'mdf_file',
}
"""By the ending of the file's name."""


def read_arrays(path: Path, suffix: str = '') -> NamedArrays:
    """Return the arrays of a file, by the ending of its name, or of such names as are told.

    Raises
    ------
    RecordingError
        Damaged or truncated, or the library that reads it is not installed.
    """
    reader = import_module(f'modal_recordings.formats.{READERS[suffix or path.suffix.lower()]}')
    found: NamedArrays = reader.read(path)
    return found
