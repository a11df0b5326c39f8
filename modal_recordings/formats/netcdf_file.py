"""NetCDF files: the classic format (SciPy) and NetCDF 4, which is HDF5."""

from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import netcdf_file

from modal_core.errors import RecordingError
from modal_recordings.formats import hdf_file
from modal_recordings.formats.named_arrays import NamedArray, NamedArrays, unit_text
from modal_recordings.formats.packed import unpacked

NEWEST_CLASSIC = b'CDF\x05'


def read(path: Path) -> NamedArrays:
    """Return the variables of a NetCDF file.

    Raises
    ------
    RecordingError
        Damaged or truncated.
    """
    with path.open('rb') as file:
        magic = file.read(4)
    if not magic.startswith(b'CDF'):
        return hdf_file.read(path)
    if magic == NEWEST_CLASSIC:
        raise RecordingError(
            'NetCDF of the 64-bit data format (CDF-5)',
            where=path,
            expected='the classic format or NetCDF 4',
            advice='convert it: nccopy -k nc4',
        )
    try:
        with netcdf_file(path, 'r', mmap=False) as content:
            numbers = {k: float(v) for k, v in content._attributes.items() if np.size(v) == 1
                       and np.asarray(v).dtype.kind in 'fiu'}  # fmt: skip
            arrays = tuple(_variable(name, each) for name, each in content.variables.items())
    except (ValueError, TypeError, OSError, EOFError, LookupError, MemoryError,
            OverflowError) as error:  # fmt: skip
        raise RecordingError(
            'damaged or truncated NetCDF file', where=path, found=str(error)
        ) from error
    return NamedArrays(tuple(each for each in arrays if each.values.shape), numbers)


def _variable(name: str, variable: Any) -> NamedArray:
    unit = unit_text(getattr(variable, 'units', ''))
    values = np.array(variable.data)
    if not values.shape:
        return NamedArray(name, values, unit=unit)
    return NamedArray(name, unpacked(values, variable._attributes), unit=unit)
