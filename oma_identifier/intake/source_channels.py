"""Which channels the columns of a measurement are."""

from modal_core.channel import Channel, SensorLayout
from modal_core.measurements import SampleBlock, StampedSamples


def channels_of(
    measurement: StampedSamples | SampleBlock, layout: SensorLayout | None
) -> list[Channel | None]:
    """Return the channel of each column; None of those the layout does not know.

    Parameters
    ----------
    measurement : StampedSamples or SampleBlock
        Of one source.
    layout : SensorLayout or None
        None: every column is a channel.
    """
    if isinstance(measurement, SampleBlock):
        return [_channel_of_block(name, layout) for name in measurement.channel_names]
    return _channels_of_sensor(measurement, layout)


def _channel_of_block(name: str, layout: SensorLayout | None) -> Channel | None:
    if layout is None:
        return Channel(name=name)
    return next((channel for channel in layout.channels if channel.name == name), None)


def _channels_of_sensor(
    samples: StampedSamples, layout: SensorLayout | None
) -> list[Channel | None]:
    if samples.channel_names:
        return [_channel_of_block(name, layout) for name in samples.channel_names]
    plain = samples.source.strip('/')
    axes = {'x': (1.0, 0.0, 0.0), 'y': (0.0, 1.0, 0.0), 'z': (0.0, 0.0, 1.0)}
    if layout is None:
        return [
            Channel(name=f'{plain}.{axis}', frame_id=samples.frame_id, direction=direction)
            for axis, direction in axes.items()
        ]
    for sensor in layout:
        topic = sensor.topic.strip('/')
        if topic and (plain == topic or plain.endswith(f'/{topic}')):
            by_axis = dict(zip(sensor.axes, sensor.channels(), strict=True))
            return [by_axis.get(axis) for axis in axes]
    return [None, None, None]
