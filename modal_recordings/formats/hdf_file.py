"""HDF5 files, NetCDF 4 files, which are HDF5, and MATLAB 7.3 files, which are, too."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from modal_core.errors import RecordingError
from modal_recordings.formats.named_arrays import NamedArray, NamedArrays, stated_rates
from modal_recordings.formats.optional_library import optional_library
from modal_recordings.formats.packed import unpacked
from modal_recordings.tables import heading_of

UNIT_NAMES = ('unit', 'units', 'Unit', 'Units')
COLUMN_NAMES = ('channel_names', 'channels', 'columns', 'labels', 'names')
DEEPEST, LONGEST_TEXT = 8, 1000
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


class Field:
    """One column of a table of records, as PyTables and LabVIEW write it."""

    def __init__(self, dataset: Any, column: str) -> None:
        self._dataset, self._column = dataset, column
        self.shape: tuple[int, ...] = dataset.shape
        self.dtype = dataset.dtype[column]

    def __getitem__(self, key: Any) -> Any:
        """Return a part."""
        return self._dataset[key][self._column]


def read(path: Path, matlab: bool = False) -> NamedArrays:
    """Return the datasets of an HDF5 or NetCDF 4 file; those of groups are called ``group/name``.

    Raises
    ------
    RecordingError
        Damaged or truncated, or h5py is not installed.
    """
    h5py = optional_library('h5py', path)
    arrays: list[NamedArray] = []
    texts: dict[str, str] = {}
    try:
        file = h5py.File(path, 'r')
        numbers = _numbers(file.attrs)
        for found in _datasets(file, h5py):
            _take(found, matlab, arrays, numbers, texts)
    except (OSError, RuntimeError, KeyError, ValueError) as error:
        raise RecordingError(
            'damaged or truncated HDF5 file', where=path, found=str(error)
        ) from error
    return NamedArrays(tuple(arrays), numbers, texts=texts)


@dataclass(frozen=True, slots=True)
class Found:
    """A dataset, with what the groups around it say of all that is in them."""

    name: str
    dataset: Any
    unit: str = ''
    sample_rate_hz: float | None = None


def _take(
    found: Found,
    matlab: bool,
    arrays: list[NamedArray],
    numbers: dict[str, float],
    texts: dict[str, str],
) -> None:
    """Put a dataset where it belongs: with the arrays, the numbers or the texts."""
    name, dataset = found.name, found.dataset
    kind = dataset.dtype.kind
    if dataset.attrs.get('MATLAB_class', b'') == b'char':
        if 0 < dataset.size <= LONGEST_TEXT and kind in 'iu':
            texts[name] = ''.join(map(chr, np.ravel(dataset[()]).tolist()))
    elif dataset.shape is not None and dataset.size == 1 and kind in 'fiu':
        numbers[name] = float(np.ravel(dataset[()])[0])
    elif kind in 'fiu' and dataset.shape:
        numbers |= {f'{name}/{k}': v for k, v in _numbers(dataset.attrs).items()}
        arrays.append(_array(found, matlab))
    elif kind == 'V' and dataset.dtype.names and len(dataset.shape) == 1:
        arrays += [
            NamedArray(f'{name}/{column}', Field(dataset, column))
            for column in dataset.dtype.names
            if dataset.dtype[column].kind in 'fiu' and not dataset.dtype[column].shape
        ]


def _datasets(
    group: Any, h5py: Any, around: Found | None = None, depth: int = 0
) -> Iterator[Found]:
    """Yield the datasets; links to other files and objects of MATLAB are no data."""
    before = f'{around.name}/' if around else ''
    unit = _unit(group.attrs) or (around.unit if around else '')
    rate_hz = _rate_hz(group.attrs) or (around.sample_rate_hz if around else None)
    for name in group:
        link = group.get(name, getlink=True)
        if isinstance(link, h5py.ExternalLink | h5py.SoftLink) or name.startswith('#'):
            continue
        item = group[name]
        here = Found(f'{before}{name}', item, unit, rate_hz)
        if isinstance(item, h5py.Dataset) and not _is_dimension(item):
            yield here
        elif isinstance(item, h5py.Group) and depth < DEEPEST:
            yield from _datasets(item, h5py, here, depth + 1)


def _is_dimension(dataset: Any) -> bool:
    name = dataset.attrs.get('NAME', b'')
    return isinstance(name, bytes) and name.startswith(NO_VARIABLE)


def _array(found: Found, matlab: bool) -> NamedArray:
    attributes = found.dataset.attrs
    rate_hz = _rate_hz(attributes) or found.sample_rate_hz
    own = _texts(attributes, UNIT_NAMES)
    array = NamedArray(
        found.name,
        Transposed(found.dataset) if matlab else unpacked(found.dataset, attributes),
        unit=_unit(attributes),
        headings=_texts(attributes, COLUMN_NAMES),
        sample_rate_hz=rate_hz,
        units=own if len(own) > 1 else (),
    )
    is_time = heading_of(array.last_name, '', found.name).is_time
    return array if array.unit or is_time else replace(array, unit=found.unit)


def _unit(attributes: Any) -> str:
    """Return the one unit that is stated."""
    texts = _texts(attributes, UNIT_NAMES)
    return texts[0].split(' since ')[0] if len(texts) == 1 else ''


def _rate_hz(attributes: Any) -> float | None:
    return next(iter(stated_rates(_numbers(attributes)).values()), None)


def _texts(attributes: Any, names: Sequence[str]) -> tuple[str, ...]:
    """Return the text or the texts of the first attribute there is."""
    value = next((attributes[name] for name in names if name in attributes), None)
    cells = [] if value is None else np.ravel(np.asarray(value, dtype=object)).tolist()
    return tuple(
        cell.decode('utf-8', 'replace') if isinstance(cell, bytes) else str(cell) for cell in cells
    )


def _numbers(attributes: Any) -> dict[str, float]:
    return {
        key: float(np.ravel(value)[0])
        for key, value in attributes.items()
        if np.size(value) == 1 and np.asarray(value).dtype.kind in 'fiu'
    }
