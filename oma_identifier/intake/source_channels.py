"""Which channels the columns of a measurement are, and their values in SI units."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modal_core.channel import AXES, Channel, Sensor, SensorLayout
from modal_core.measurements import SampleBlock, StampedSamples
from modal_core.units import ACCELERATION, ANGULAR_VELOCITY, named_unit, Unit


def channels_of(
    measurement: StampedSamples | SampleBlock,
    layout: SensorLayout | None,
    *,
    gyroscopes: bool = False,
) -> list[Channel | None]:
    """Return the channel of each column of :func:`columns_of`; None of those that are not used.

    Parameters
    ----------
    measurement : StampedSamples or SampleBlock
        Of one source.
    layout : SensorLayout or None
        None: every column is a channel.
    gyroscopes : bool
        Use the angular velocities of an Imu.
    """
    names = measurement.channel_names
    if not names and isinstance(measurement, StampedSamples):
        found = _channels_of_sensor(measurement, layout)
        return [*found, *_gyroscope(found)] if gyroscopes else found
    units = measurement.units or ('',) * len(names)
    return [_named(name, unit, layout) for name, unit in zip(names, units, strict=True)]


def columns_of(
    measurement: StampedSamples | SampleBlock, *, gyroscopes: bool = False
) -> NDArray[np.floating]:
    """Return the values as sent, (n_samples, n_columns), those of gyroscopes last."""
    if not gyroscopes or isinstance(measurement, SampleBlock) or measurement.channel_names:
        return measurement.acceleration
    turns = measurement.angular_velocity
    return np.hstack(
        [
            measurement.acceleration,
            np.full_like(measurement.acceleration, np.nan) if turns is None else turns,
        ]
    )


def _named(name: str, unit: str, layout: SensorLayout | None) -> Channel | None:
    """Return a channel by its name; a unit that its source states goes before the layout's."""
    bare, stated = (name, Unit(unit)) if unit else named_unit(name)
    if layout is None:
        known = Channel(bare)
    else:
        named = [channel for channel in layout.channels if channel.name in (name, bare)]
        if not named:
            return None
        known = named[0]
    return known if stated is None else replace(known, unit=stated.si, scale=stated.factor)


def _channels_of_sensor(
    samples: StampedSamples, layout: SensorLayout | None
) -> list[Channel | None]:
    plain = samples.source.strip('/')
    if layout is None:
        own = Sensor(plain, samples.frame_id)
        return [*own.channels()]
    for sensor in layout:
        topic = sensor.topic.strip('/')
        if topic and (plain == topic or plain.endswith(f'/{topic}')):
            by_axis = dict(zip(sensor.axes, sensor.channels(), strict=True))
            return [by_axis.get(axis) for axis in AXES]
    return [None, None, None]


def _gyroscope(axes: list[Channel | None]) -> list[Channel | None]:
    """Return the turns about the axes of an accelerometer."""
    return [
        None
        if axis is None or axis.unit != ACCELERATION
        else replace(
            axis,
            name='.gyro_'.join(axis.name.rsplit('.', 1)),
            unit=ANGULAR_VELOCITY,
            scale=1.0,
        )
        for axis in axes
    ]
