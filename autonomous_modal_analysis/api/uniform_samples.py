"""All accelerations of a recording on one uniform grid, as one array."""

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import RecordingError
from modal_core.measurements import SampleBlock
from modal_core.samples import Samples
from modal_core.units import ACCELERATION
from modal_core.window import Window
from modal_recordings import ArrayRecording, Recording, RecordingInfo
from oma_identifier.intake import SampleBuffer
from oma_identifier.settings import IdentificationSettings

BEYOND_S = 5.0
"""How far the only window reaches beyond the stamps of a recording, not to end before it does."""


@dataclass(frozen=True, slots=True)
class UniformSamples:
    """Accelerations on one grid.

    Parameters
    ----------
    acceleration : (n_samples, n_channels) array [m/s²]
        NaN throughout for a channel the identifier excludes: flat, clipped, or with samples lost.
    sample_rate_hz : float [Hz]
        Of the grid.
    channel_names : tuple of str
        Columns.
    units : tuple of str
        SI units of the columns.
    """

    acceleration: NDArray[np.float64]
    sample_rate_hz: float
    channel_names: tuple[str, ...]
    units: tuple[str, ...]


def uniform_samples(recording: Recording, info: RecordingInfo) -> UniformSamples:
    """Return all channels on one grid, made as the identifier makes it.

    Parameters
    ----------
    recording : Recording
        Read once.
    info : RecordingInfo
        How long it is, and which channels it has.

    Raises
    ------
    RecordingError
        There is nothing to return, or gaps and new starts divide it into several stretches.
    """
    if isinstance(recording, ArrayRecording) and recording.stamp_ns is None:
        blocks = [b.acceleration for b in recording.measurements() if isinstance(b, SampleBlock)]
        values = np.concatenate(blocks, dtype=np.float64)
        names = recording.channel_names
        return UniformSamples(values, recording.sample_rate_hz, names, recording.units)
    found = one_stretch(recording, info)
    place = {name: column for column, name in enumerate(info.channels)}
    values = np.full((len(found.acceleration), len(place)), np.nan)
    values[:, [place[name] for name in found.channel_names]] = found.acceleration
    known = {channel.name: channel.unit for channel in found.channels}
    units = tuple(known.get(name, ACCELERATION) for name in place)
    return UniformSamples(values, found.sample_rate_hz, info.channels, units)


def one_stretch(recording: Recording, info: RecordingInfo) -> Samples:
    """Return what the identifier makes of a recording that has no gap, without poor channels.

    Raises
    ------
    RecordingError
        Gaps and new starts divide it into several stretches.
    """
    window_s = max(1.0, math.ceil(info.duration_s) + BEYOND_S)
    buffer = SampleBuffer(IdentificationSettings(window_s=window_s, hop_s=window_s))
    windows: list[Window] = []
    for measurement in recording.measurements():
        buffer.add(measurement)
        windows += buffer.windows()
    windows += buffer.finish()
    if len(windows) == 1 and buffer.counters.n_segments == 1:
        return windows[0].samples
    why = (*buffer.counters.texts.values(), *buffer.counters.reasons)
    raise RecordingError(
        'not one uninterrupted stretch of samples',
        where=recording.path,
        found=f'{buffer.counters.n_segments} stretches: {", ".join(why[:3])}',
        advice='identify() takes it as it is',
    )
