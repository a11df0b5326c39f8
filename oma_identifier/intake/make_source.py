"""A source made of its first measurement."""

import numpy as np

from modal_core.channel import SensorLayout
from modal_core.measurements import NANOSECONDS_PER_SECOND, SampleBlock, StampedSamples
from oma_identifier.intake.source import sent_by, Source
from oma_identifier.intake.source_channels import channels_of
from oma_identifier.time_axis import BlockClock, SourceStream


def make_source(
    measurement: StampedSamples | SampleBlock,
    layout: SensorLayout | None,
    *,
    gyroscopes: bool = False,
) -> Source | None:
    """Return a new source for a measurement; None when the layout knows none of its channels."""
    clock = None
    if isinstance(measurement, SampleBlock):
        clock = BlockClock(measurement.sample_rate_hz)
    gyroscopes = gyroscopes and _turns(measurement)
    given = channels_of(measurement, layout, gyroscopes=gyroscopes)
    columns = tuple(index for index, channel in enumerate(given) if channel is not None)
    channels = tuple(channel for channel in given if channel is not None)
    if not channels:
        return None
    source = Source(
        name=measurement.source,
        channels=channels,
        columns=slice(None) if len(columns) == len(given) else columns,
        sent=sent_by(measurement),
        stream=SourceStream(len(channels), dtype=_precision(measurement)),
        clock=clock,
        gyroscopes=gyroscopes,
    )
    if clock is not None:
        source.period_ns = NANOSECONDS_PER_SECOND / clock.sample_rate_hz
    return source


def _turns(measurement: StampedSamples | SampleBlock) -> bool:
    """Tell whether a source has gyroscopes; an Imu without them sends no numbers, or zeros."""
    if isinstance(measurement, SampleBlock) or measurement.channel_names:
        return True
    turns = measurement.angular_velocity
    return turns is not None and bool(np.isfinite(turns).any() and np.nan_to_num(turns).any())


def _precision(measurement: StampedSamples | SampleBlock) -> 'np.dtype[np.floating]':
    """Return the least precision that loses nothing of what is sent, in the machine's order."""
    single = measurement.acceleration.dtype.itemsize <= np.dtype(np.float32).itemsize
    return np.dtype(np.float32 if single else np.float64)
