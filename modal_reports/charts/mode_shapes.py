"""Mode shapes: a turning wireframe per mode, or one bar per channel without geometry."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from modal_core.mode import ModeSet
from modal_reports.charts.geometry import Geometry
from modal_reports.charts.plain_numbers import numbers
from modal_reports.quantities import DAMPING, FREQUENCY


def mode_shapes_data(
    modes: ModeSet,
    geometry: Geometry | None = None,
    displacements: Sequence[NDArray[np.complex128]] = (),
) -> dict[str, object]:
    """Return what the pictures of the mode shapes draw.

    Parameters
    ----------
    modes : ModeSet
        One picture each.
    geometry : Geometry or None
        The arm at rest; without it there is one bar per channel.
    displacements : sequence of (n_points, 3) complex array
        One per mode, in their order.
    """
    shown = []
    for index, mode in enumerate(modes):
        entry = {
            'id': int(mode.id),
            'harmonic': bool(mode.harmonic),
            'frequency': FREQUENCY.text(mode.frequency_hz),
            'damping': DAMPING.text(mode.damping_ratio),
            'shape_real': numbers(np.real(mode.shape)),
            'shape_imag': numbers(np.imag(mode.shape)),
        }
        if geometry is not None and index < len(displacements):
            moved = np.asarray(displacements[index])
            entry['moved_real'] = numbers(moved.real)
            entry['moved_imag'] = numbers(moved.imag)
        shown.append(entry)
    return {
        'modes': shown,
        'geometry': _wireframe(geometry),
        'channel_names': list(modes.channel_names),
    }


def _wireframe(geometry: Geometry | None) -> dict[str, object] | None:
    if geometry is None:
        return None
    return {
        'points_m': numbers(np.asarray(geometry.points_m)),
        'lines': [list(map(int, line)) for line in geometry.lines],
        'sensors': list(map(int, geometry.sensors)),
    }
