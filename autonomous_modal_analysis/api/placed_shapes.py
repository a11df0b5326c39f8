"""Mode shapes at the places a sensor layout gives, without a robot."""

from collections.abc import Collection, Sequence

import numpy as np
from numpy.typing import NDArray

from modal_core.channel import SensorLayout
from modal_core.errors import LayoutError
from modal_core.mode import ModeSet
from modal_reports import Geometry, sensor_displacements

Displacements = tuple[NDArray[np.complex128], ...]


def placed_shapes(
    layout: SensorLayout | None,
    modes: ModeSet,
    lines: Sequence[Sequence[str]] = (),
    others: Collection[str] = (),
) -> tuple[Geometry, Displacements] | None:
    """Return the sensors as points, and how each mode moves them, (n_points, 3) [-].

    None where the layout does not place every channel that measures motion along a direction in
    one frame, at two places at least.

    Parameters
    ----------
    layout : SensorLayout or None
        Places and directions.
    modes : ModeSet
        Shapes.
    lines : sequence of sequence of str
        Names of sensors to connect.
    others : collection of str
        Channels that need no place: they measure no motion along a direction, as gyroscopes do.

    Raises
    ------
    LayoutError
        A line names no sensor.
    """
    known = {} if layout is None else {channel.name: channel for channel in layout.channels}
    if layout is None or not set(modes.channel_names) - set(others) <= set(known):
        return None
    placed = {name: channel for name, channel in known.items() if channel.is_straight}
    rows = [row for row, name in enumerate(modes.channel_names) if name in placed]
    sensors = [one for one in layout if any(each.name in placed for each in one.channels())]
    if not rows:
        return None
    points_m = np.array([sensor.position_m for sensor in sensors])
    if len({sensor.frame_id for sensor in sensors}) != 1 or not np.ptp(points_m, axis=0).any():
        return None
    names = [sensor.name for sensor in sensors]
    geometry = Geometry(
        points_m=points_m,
        lines=tuple(tuple(_place(name, names) for name in line) for line in lines),
        sensors=tuple(range(len(sensors))),
        fixed=(),
    )
    owner = {c.name: number for number, sensor in enumerate(sensors) for c in sensor.channels()}
    channels = [placed[modes.channel_names[row]] for row in rows]
    directions = np.array([channel.direction for channel in channels])
    at = [owner[channel.name] for channel in channels]
    return geometry, tuple(
        sensor_displacements(geometry, mode.shape[rows], directions, at) for mode in modes
    )


def _place(name: str, names: Sequence[str]) -> int:
    if name not in names:
        raise LayoutError('no such sensor', where='lines', found=name, expected=', '.join(names))
    return names.index(name)
