"""Mode shapes at the places a sensor layout gives, without a robot."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from modal_core.channel import SensorLayout
from modal_core.errors import LayoutError
from modal_core.mode import ModeSet
from modal_reports import Geometry, sensor_displacements

Displacements = tuple[NDArray[np.complex128], ...]


def placed_shapes(
    layout: SensorLayout | None, modes: ModeSet, lines: Sequence[Sequence[str]] = ()
) -> tuple[Geometry, Displacements] | None:
    """Return the sensors as points, and how each mode moves them, (n_points, 3) [-].

    None where the layout does not place every channel in one frame, at two places at least.

    Parameters
    ----------
    layout : SensorLayout or None
        Places and directions.
    modes : ModeSet
        Shapes.
    lines : sequence of sequence of str
        Names of sensors to connect.

    Raises
    ------
    LayoutError
        A line names no sensor.
    """
    placed = {} if layout is None else {channel.name: channel for channel in layout.channels}
    if layout is None or not modes.channel_names or not set(modes.channel_names) <= set(placed):
        return None
    sensors = list(layout)
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
    directions = np.array([placed[name].direction for name in modes.channel_names])
    at = [owner[name] for name in modes.channel_names]
    return geometry, tuple(
        sensor_displacements(geometry, mode.shape, directions, at) for mode in modes
    )


def _place(name: str, names: Sequence[str]) -> int:
    if name not in names:
        raise LayoutError('no such sensor', where='lines', found=name, expected=', '.join(names))
    return names.index(name)
