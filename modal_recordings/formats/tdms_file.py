"""TDMS files of LabVIEW and FlexLogger."""

import logging
from pathlib import Path
from typing import Any

from modal_core.errors import RecordingError
from modal_recordings.formats.named_arrays import NamedArray, NamedArrays
from modal_recordings.formats.optional_library import optional_library

STEP, UNIT = 'wf_increment', ('unit_string', 'NI_UnitDescription')


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
    except (ValueError, OSError, EOFError, KeyError, IndexError, RuntimeError) as error:
        raise RecordingError(
            'damaged or truncated TDMS file', where=path, found=str(error)
        ) from error


def _channel(channel: Any) -> NamedArray:
    step_s = channel.properties.get(STEP)
    unit = next((channel.properties[key] for key in UNIT if key in channel.properties), '')
    return NamedArray(
        f'{channel.group_name}/{channel.name}',
        Channel(channel),
        unit=str(unit),
        headings=(channel.name,),
        sample_rate_hz=1.0 / float(step_s) if step_s else None,
    )
