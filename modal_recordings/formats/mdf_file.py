"""MDF files (ASAM MDF 3 and 4), as CANape, INCA and Dewesoft write them."""

from collections.abc import Iterator
from contextlib import contextmanager
import gc
import logging
from pathlib import Path
import sys
from typing import Any

import numpy as np

from modal_core.errors import RecordingError
from modal_recordings.formats.named_arrays import NamedArray, NamedArrays
from modal_recordings.formats.optional_library import optional_library

MAGIC = (b'MDF     ', b'UnFinMF ')


def read(path: Path) -> NamedArrays:
    """Return the channels of an MDF file by group and name, and the time of each group.

    Raises
    ------
    RecordingError
        Damaged, truncated or never finished, or asammdf is not installed.
    """
    library = optional_library('asammdf', path)
    with path.open('rb') as file:
        magic = file.read(8)
    if magic != MAGIC[0]:
        what = 'MDF file that was never finished' if magic == MAGIC[1] else 'not an MDF file'
        raise RecordingError(what, where=path, expected=repr(MAGIC[0]))
    groups: list[list[Any]] = []
    reason = ''
    with _silent():
        try:
            with library.MDF(path) as content:
                groups = _groups(content)
        except Exception as error:  # noqa: BLE001 - asammdf raises many kinds
            reason = str(error) or type(error).__name__
    if reason:
        raise RecordingError('damaged or truncated MDF file', where=path, found=reason)
    arrays = []
    for number, signals in enumerate(groups):
        before = f'{number}/' if len(groups) > 1 else ''
        arrays.append(NamedArray(f'{before}time', signals[0].timestamps, unit='s'))
        arrays += [NamedArray(before + each.name, each.samples, each.unit) for each in signals]
    return NamedArrays(tuple(arrays))


def _groups(content: Any) -> list[list[Any]]:
    """Return the signals of each group of channels, which share a clock, numbers alone."""
    groups = []
    for number, group in enumerate(content.groups):
        found = [
            content.get(group=number, index=index)
            for index in range(len(group.channels))
            if index != content.masters_db.get(number)
        ]
        groups.append([each for each in found if np.asarray(each.samples).dtype.kind in 'fiu'])
    return [each for each in groups if each]


@contextmanager
def _silent() -> Iterator[None]:
    """Keep the library's log quiet, and readers that fail again when they are taken away."""
    hook, log = sys.unraisablehook, logging.getLogger('asammdf')
    was_disabled = log.disabled
    sys.unraisablehook, log.disabled = (lambda _: None), True
    try:
        yield
    finally:
        gc.collect()
        sys.unraisablehook, log.disabled = hook, was_disabled
