"""Mode shapes: a turning wireframe per mode, or one bar per channel without geometry."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modal_core.mode import Mode, ModeSet
from modal_reports.charts.geometry import Geometry
from modal_reports.charts.plain_numbers import numbers
from modal_reports.quantities import DAMPING, FREQUENCY


@dataclass(frozen=True, slots=True)
class OtherShape:
    """A shape to lie over another one, scaled to it.

    Parameters
    ----------
    mode : Mode
        Whose it is; its shape has the channels of the other one, NaN where it has none.
    displacement : (n_points, 3) complex array or None
        Of the points of the arm.
    """

    mode: Mode
    displacement: NDArray[np.complex128] | None = None

    def entry(self) -> dict[str, object]:
        """Return what is drawn."""
        entry: dict[str, object] = {
            'frequency': FREQUENCY.text(self.mode.frequency_hz),
            'damping': DAMPING.text(self.mode.damping_ratio),
            'shape_real': numbers(np.real(self.mode.shape)),
            'shape_imag': numbers(np.imag(self.mode.shape)),
        }
        if self.displacement is not None:
            entry['moved_real'] = numbers(self.displacement.real)
            entry['moved_imag'] = numbers(self.displacement.imag)
        return entry


def mode_shapes_data(
    modes: ModeSet,
    geometry: Geometry | None = None,
    displacements: Sequence[NDArray[np.complex128]] = (),
    others: Sequence[OtherShape] = (),
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
    others : sequence of OtherShape
        One per mode, in their order, to lie over it.
    """
    shown = []
    for index, mode in enumerate(modes):
        entry: dict[str, object] = {
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
        if index < len(others):
            entry['other'] = others[index].entry()
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
