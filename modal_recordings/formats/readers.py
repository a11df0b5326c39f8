"""Which file reads which kind of file; each has a function ``read(path)``.

A reader is imported with the first file of its kind.
"""

from importlib import import_module
from pathlib import Path

from modal_recordings.formats.named_arrays import NamedArrays

READERS = {
    '.uff': 'universal.universal_file',
    '.unv': 'universal.universal_file',
    '.npz': 'formats.numpy_file',
    '.mat': 'formats.matlab_file',
    '.h5': 'formats.hdf_file',
    '.hdf5': 'formats.hdf_file',
    '.nc': 'formats.netcdf_file',
    '.wav': 'formats.wav_file',
    '.tdms': 'formats.tdms_file',
    '.lvm': 'formats.lvm_file',
    '.mf4': 'formats.mdf_file',
    '.mdf': 'formats.mdf_file',
}
"""By the ending of the file's name."""


def read_arrays(path: Path, suffix: str = '') -> NamedArrays:
    """Return the arrays of a file, by the ending of its name, or of such names as are told.

    Raises
    ------
    RecordingError
        Damaged or truncated, or the library that reads it is not installed.
    """
    reader = import_module(f'modal_recordings.{READERS[suffix or path.suffix.lower()]}')
    found: NamedArrays = reader.read(path)
    return found
