"""Files of other programs that hold arrays: MATLAB, HDF5, NetCDF, WAV, TDMS, MDF.

In comes a file; out goes the table of its responses, with the names, units and rate it states.
What a file neither states nor implies is asked for by name. A file that is cut off is refused.
"""

from modal_recordings.formats.lvm_file import is_lvm
from modal_recordings.formats.named_arrays import NamedArray, NamedArrays, table_of, tables_of
from modal_recordings.formats.readers import read_arrays, READERS

__all__ = [
    'READERS',
    'NamedArray',
    'NamedArrays',
    'is_lvm',
    'read_arrays',
    'table_of',
    'tables_of',
]
