"""HDF5 files, NetCDF 4 files, which are HDF5, and MATLAB 7.3 files, which are, too."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from modal_core.errors import RecordingError
from modal_recordings.formats.named_arrays import (
    NamedArray,
    NamedArrays,
    stated_rates,
    unit_text,
)
from modal_recordings.formats.optional_library import optional_library
from modal_recordings.formats.packed import unpacked

UNIT_NAMES = ('unit', 'units', 'Unit', 'Units')
DEEPEST = 8
NO_VARIABLE = b'This is a netCDF dimension but not a netCDF variable'
"""How NetCDF 4 calls the dataset of a dimension that has no values."""


class Transposed:
    """A dataset whose axes MATLAB counts the other way round."""

    def __init__(self, dataset: Any) -> None:
        self._dataset = dataset
        self.shape: tuple[int, ...] = dataset.shape[::-1]
        self.dtype = dataset.dtype

    def __getitem__(self, key: Any) -> Any:
        """Return a part."""
        keys = key if isinstance(key, tuple) else (key,)
        if len(self.shape) == 1:
            return self._dataset[keys[0]]
        first, second = (*keys, slice(None))[:2]
        return np.asarray(self._dataset[second, first]).T


def read(path: Path, matlab: bool = False) -> NamedArrays:
    """Return the datasets of an HDF5 or NetCDF 4 file; those of groups are called ``group/name``.

    Raises
    ------
    RecordingError
        Damaged or truncated, or h5py is not installed.
    """
    h5py = optional_library('h5py', path)
    try:
        file = h5py.File(path, 'r')
        datasets = list(_datasets(file, h5py))
        numbers = _numbers(file.attrs)
        arrays = []
        for name, dataset in datasets:
            if dataset.shape is not None and dataset.size == 1 and dataset.dtype.kind in 'fiu':
                numbers[name] = float(np.ravel(dataset[()])[0])
            elif dataset.dtype.kind in 'fiu' and dataset.shape:
                numbers |= {f'{name}/{k}': v for k, v in _numbers(dataset.attrs).items()}
                arrays.append(_array(name, dataset, matlab))
    except (OSError, RuntimeError, KeyError, ValueError) as error:
        raise RecordingError(
            'damaged or truncated HDF5 file', where=path, found=str(error)
        ) from error
    return NamedArrays(tuple(arrays), numbers)


def _datasets(
    group: Any, h5py: Any, before: str = '', depth: int = 0
) -> Iterator[tuple[str, Any]]:
    """Yield the datasets; links to other files and objects of MATLAB are no data."""
    for name in group:
        link = group.get(name, getlink=True)
        if isinstance(link, h5py.ExternalLink | h5py.SoftLink) or name.startswith('#'):
            continue
        item = group[name]
        if isinstance(item, h5py.Dataset) and not _is_dimension(item):
            yield f'{before}{name}', item
        elif isinstance(item, h5py.Group) and depth < DEEPEST:
            yield from _datasets(item, h5py, f'{before}{name}/', depth + 1)


def _is_dimension(dataset: Any) -> bool:
    name = dataset.attrs.get('NAME', b'')
    return isinstance(name, bytes) and name.startswith(NO_VARIABLE)


def _array(name: str, dataset: Any, matlab: bool) -> NamedArray:
    unit = next((unit_text(dataset.attrs[key]) for key in UNIT_NAMES if key in dataset.attrs), '')
    rate_hz = next(iter(stated_rates(_numbers(dataset.attrs)).values()), None)
    values = Transposed(dataset) if matlab else unpacked(dataset, dataset.attrs)
    return NamedArray(name, values, unit=unit, sample_rate_hz=rate_hz)


def _numbers(attributes: Any) -> dict[str, float]:
    return {
        key: float(np.ravel(value)[0])
        for key, value in attributes.items()
        if np.size(value) == 1 and np.asarray(value).dtype.kind in 'fiu'
    }
