"""TDMS files of LabVIEW and FlexLogger."""

from collections.abc import Mapping
import logging
from pathlib import Path
import struct
from typing import Any

import numpy as np

from modal_core.errors import RecordingError
from modal_recordings.formats.named_arrays import NamedArray, NamedArrays
from modal_recordings.formats.optional_library import optional_library

STEP, START, UNIT = 'wf_increment', 'wf_start_time', ('unit_string', 'NI_UnitDescription')
OFFSET, EPOCH = 'wf_start_offset', np.datetime64('1970-01-01T00:00:00')


class Channel:
    """Samples of a channel, read where they are asked for."""

    def __init__(self, channel: Any) -> None:
        self._channel = channel
        self.shape: tuple[int, ...] = (len(channel),)
        self.dtype = channel.dtype

    def __getitem__(self, key: Any) -> Any:
        """Return a part."""
        start, stop, _ = key.indices(self.shape[0])
        return self._channel.read_data(start, stop - start, scaled=True)


class Stamps(Channel):
    """Times of day of a channel, in seconds since 1970."""

    def __init__(self, channel: Any) -> None:
        super().__init__(channel)
        self.dtype = np.dtype(np.float64)

    def __getitem__(self, key: Any) -> Any:
        """Return a part."""
        return (super().__getitem__(key) - EPOCH) / np.timedelta64(1, 's')


def read(path: Path) -> NamedArrays:
    """Return the channels of a TDMS file, called ``group/channel``.

    Raises
    ------
    RecordingError
        Damaged or truncated, or npTDMS is not installed.
    """
    library = optional_library('nptdms', path)
    library.log.log_manager.set_level(logging.ERROR)
    try:
        file = library.TdmsFile.open(path)
        if file.file_status.incomplete_final_segment:
            raise ValueError('its last segment is cut off')
        return NamedArrays(tuple(_channel(each) for g in file.groups() for each in g.channels()))
    except (ValueError, OSError, EOFError, LookupError, RuntimeError, TypeError, OverflowError,
            MemoryError, AttributeError, struct.error) as error:  # fmt: skip
        raise RecordingError(
            'damaged or truncated TDMS file', where=path, found=str(error)
        ) from error


def _channel(channel: Any) -> NamedArray:
    step_s = channel.properties.get(STEP)
    unit = next((channel.properties[key] for key in UNIT if key in channel.properties), '')
    are_stamps = channel.dtype.kind == 'M'
    return NamedArray(
        f'{channel.group_name}/{channel.name}',
        Stamps(channel) if are_stamps else Channel(channel),
        unit='s' if are_stamps else str(unit),
        headings=(channel.name,),
        sample_rate_hz=1.0 / float(step_s) if step_s else None,
        start_s=_start_s(channel.properties),
    )


def _start_s(properties: Mapping[str, Any]) -> float | None:
    """Return when a channel began: its time, and its offset to that."""
    start = properties.get(START)
    if not isinstance(start, np.datetime64) or np.isnat(start):
        return None
    return float((start - EPOCH) / np.timedelta64(1, 's')) + float(properties.get(OFFSET, 0.0))
