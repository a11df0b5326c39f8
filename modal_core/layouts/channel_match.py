"""Which channel of a layout a recorded name means, whatever its separators and case."""

from collections.abc import Sequence
from dataclasses import replace

from modal_core.channel import Channel, SensorLayout
from modal_core.units import ACCELERATION, named_unit, Unit


def match_channel(name: str, layout: SensorLayout) -> Channel | None:
    """Return the layout's accelerometer of a recorded name, tolerant of separators and case.

    A unit that ends the name, ``elbow.x [g]``, goes before the layout's.
    """
    bare, unit = named_unit(name)
    plain = plain_name(bare)
    for channel in layout.channels:
        if channel.name in (name, bare) or plain_name(channel.name) == plain:
            if unit is not None:
                channel = replace(channel, unit=unit.si, scale=unit.factor)
            return channel if channel.unit == ACCELERATION else None
    return _counted(bare, unit, layout)


def _counted(name: str, unit: Unit | None, layout: SensorLayout) -> Channel | None:
    """Return the axis of a sensor by its number: ``elbow1`` is its first."""
    for sensor in layout:
        if len(sensor.axes) == 1:
            continue
        for number, channel in enumerate(sensor.channels(), 1):
            counted = plain_name(f'{sensor.name}{number}')
            if counted == plain_name(name) and channel.unit == ACCELERATION:
                return (
                    channel if unit is None else replace(channel, unit=unit.si, scale=unit.factor)
                )
    return None


def plain_name(name: str) -> str:
    """Return a name in small letters, its parts separated by points."""
    text = name.lower().strip('/')
    for mark in '/_- :':
        text = text.replace(mark, '.')
    return text


def named_as_in(layout: SensorLayout, names: Sequence[str]) -> tuple[tuple[str, ...], str]:
    """Return the layout's names of columns, and what was assumed of them.

    Names that mean no channel stay.  Where none of them means one, columns are those of the
    layout, in its order, if they are as many.
    """
    matched = [match_channel(name, layout) for name in names]
    channels = [channel.name for channel in layout.channels]
    if any(matched):
        known = zip(names, matched, strict=True)
        return tuple(name if it is None else it.name for name, it in known), ''
    if len(names) != len(channels):
        return tuple(names), ''
    return tuple(channels), (
        f'columns {names[0]} to {names[-1]} are not called as the layout calls its channels: taken'
        f' in its order, {channels[0]} to {channels[-1]}'
    )
