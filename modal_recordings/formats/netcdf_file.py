"""NetCDF files: the classic format (SciPy) and NetCDF 4, which is HDF5."""

from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import netcdf_file

from modal_core.errors import RecordingError
from modal_recordings.formats import hdf_file
from modal_recordings.formats.named_arrays import NamedArray, NamedArrays, unit_text


def read(path: Path) -> NamedArrays:
    """Return the variables of a NetCDF file.

    Raises
    ------
    RecordingError
        Damaged or truncated.
    """
    with path.open('rb') as file:
        if file.read(3) != b'CDF':
            return hdf_file.read(path)
    try:
        with netcdf_file(path, 'r', mmap=False) as content:
            numbers = {k: float(v) for k, v in content._attributes.items() if np.size(v) == 1
                       and np.asarray(v).dtype.kind in 'fiu'}  # fmt: skip
            arrays = tuple(_variable(name, each) for name, each in content.variables.items())
    except (ValueError, TypeError, OSError, EOFError, KeyError, IndexError) as error:
        raise RecordingError(
            'damaged or truncated NetCDF file', where=path, found=str(error)
        ) from error
    return NamedArrays(tuple(each for each in arrays if each.values.shape), numbers)


def _variable(name: str, variable: Any) -> NamedArray:
    unit = unit_text(getattr(variable, 'units', ''))
    return NamedArray(name, np.array(variable.data), unit=unit)
