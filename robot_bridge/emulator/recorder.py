"""Which readings go where: channels of the common recorder, and IMUs with topics of their own."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

from modal_core.channel import ANGULAR_VELOCITY, Channel, Sensor, SensorLayout

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


def _imu_channels(sensor: Sensor) -> Iterable[Channel]:
    whole = replace(sensor, axes=ALL_AXES).channels()
    turns = (
        replace(channel, name=f'{sensor.name}.gyro_{axis}', unit=ANGULAR_VELOCITY)
        for channel, axis in zip(whole, ALL_AXES, strict=True)
    )
    return (*whole, *turns)
