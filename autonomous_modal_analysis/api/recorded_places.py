"""Mode shapes at the nodes of the universal file that was identified."""

import logging
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from modal_core.errors import RecordingError
from modal_core.mode import ModeSet
from modal_recordings.universal import direction_of
from modal_reports import Geometry, sensor_displacements

if TYPE_CHECKING:
    from autonomous_modal_analysis.api.found_modes import Placed

log = logging.getLogger(__name__)
UNIVERSAL = ('.uff', '.unv')


def recorded_places(path: Path | None, modes: ModeSet) -> 'Placed | None':
    """Return the nodes as points, and how each mode moves them, (n_points, 3) [-].

    None where the recording is no universal file with nodes, or channels are at none of them; a
    geometry that cannot be read is said, and costs nobody the modes.
    """
    told = [direction_of(name) for name in modes.channel_names]
    if path is None or path.suffix.lower() not in UNIVERSAL or not told or None in told:
        return None
    from modal_recordings.universal import read_geometry

    try:
        read = read_geometry(path)
    except RecordingError as error:
        log.warning('%s; shapes are drawn channel by channel', error)
        return None
    if read is None:
        return None
    place = {number: row for row, number in enumerate(read.numbers)}
    at = [each for each in told if each is not None]
    if not {node for node, _ in at} <= set(place):
        return None
    rows = [place[node] for node, _ in at]
    geometry = Geometry(
        points_m=read.points_m,
        lines=tuple(tuple(place[number] for number in line) for line in read.lines),
        sensors=tuple(sorted(set(rows))),
        # What nobody measured stands still, as other programs show it: it is not made up.
        fixed=tuple(row for row in place.values() if row not in rows),
        numbers=read.numbers,
    )
    directions = np.array([way for _, way in at])
    return geometry, tuple(
        sensor_displacements(geometry, mode.shape, directions, rows) for mode in modes
    )
