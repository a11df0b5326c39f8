"""Which readings go where: channels of the common recorder, and IMUs with topics of their own."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from modal_core.channel import Channel, Sensor, SensorLayout
from modal_core.measurements import (
    Measurement,
    NANOSECONDS_PER_SECOND,
    SampleBlock,
    StampedSamples,
)
from modal_core.units import ANGULAR_VELOCITY
from modal_recordings.messages import most_rows

N_IMU = 6
ALL_AXES = ('x', 'y', 'z')


@dataclass(frozen=True, slots=True)
class ImuPort:
    """One IMU.

    Parameters
    ----------
    topic, frame_id : str
        Where its messages go and what they are stamped with.
    columns : slice
        Three accelerations and three angular velocities among all channels.
    """

    topic: str
    frame_id: str
    columns: slice


@dataclass(frozen=True, slots=True)
class Recorder:
    """All channels of a cell: the recorder's first, then the IMUs', six each.

    Parameters
    ----------
    channels : tuple of Channel
        Columns of every block.
    n_recorded : int
        How many belong to the common recorder.
    imus : tuple of ImuPort
        Sensors with a topic.
    """

    channels: tuple[Channel, ...]
    n_recorded: int
    imus: tuple[ImuPort, ...]

    @classmethod
    def of(cls, layout: SensorLayout) -> 'Recorder':
        """Sort the sensors of a layout by whether they have a topic."""
        channels = [
            channel for sensor in layout if not sensor.topic for channel in sensor.channels()
        ]
        n_recorded, imus = len(channels), []
        for sensor in layout:
            if not sensor.topic:
                continue
            columns = slice(len(channels), len(channels) + N_IMU)
            imus.append(ImuPort(sensor.topic, sensor.frame_id, columns))
            channels += _imu_channels(sensor)
        return cls(tuple(channels), n_recorded, tuple(imus))

    def measurements(
        self,
        block_topic: str,
        first_index: int,
        samples: NDArray[np.float32],
        rate_hz: float,
        start_ns: int,
    ) -> Iterator[tuple[str, Measurement]]:
        """Return what each topic carries of a block of samples.

        Parameters
        ----------
        block_topic : str
            Of the common recorder.
        first_index : int
            Running number of the first sample.
        samples : (n_samples, n_channels) float32 array [m/s²], [rad/s]
            All channels.
        rate_hz : float [Hz]
            Of the samples.
        start_ns : int [ns]
            Time of the beginning; the first sample is the end of the first step.
        """
        row = first_index + 1 + np.arange(len(samples))
        stamps = start_ns + np.rint(row / rate_hz * NANOSECONDS_PER_SECOND).astype(np.int64)
        if self.n_recorded:
            names = tuple(channel.name for channel in self.channels[: self.n_recorded])
            largest = most_rows(self.n_recorded)
            for first in range(0, len(samples), largest):
                part = samples[first : first + largest, : self.n_recorded]
                yield (
                    block_topic,
                    SampleBlock(
                        block_topic, int(stamps[first]), first_index + first, rate_hz, names, part
                    ),
                )
        for port in self.imus:
            values = np.asarray(samples[:, port.columns], dtype=np.float64)
            yield (
                port.topic,
                StampedSamples(port.topic, port.frame_id, stamps, values[:, :3], values[:, 3:]),
            )


def _imu_channels(sensor: Sensor) -> Iterable[Channel]:
    whole = replace(sensor, axes=ALL_AXES).channels()
    turns = (
        replace(channel, name=f'{sensor.name}.gyro_{axis}', unit=ANGULAR_VELOCITY)
        for channel, axis in zip(whole, ALL_AXES, strict=True)
    )
    return (*whole, *turns)
