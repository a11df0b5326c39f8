"""What is written: modes, lines, where they come from, and how they move points in space."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from modal_core.mode import Mode, ModeSet
from modal_reports import Geometry


@dataclass(frozen=True)
class Exported:
    """Modes of one recording or of merged set-ups.

    Parameters
    ----------
    modes, harmonics : ModeSet
        Modes of the structure; lines of machines and drives.
    about : dict of str to str
        Name, version of the software and the like.
    geometry : Geometry or None
        Points in the base frame; None: not known.
    displacements : tuple of (n_points, 3) complex array
        One per mode, with a geometry.
    others : frozenset of str
        Channels that measure no motion along a direction, as gyroscopes do.
    """

    modes: ModeSet
    harmonics: ModeSet
    about: Mapping[str, str]
    geometry: Geometry | None = None
    displacements: tuple[NDArray[np.complex128], ...] = field(default=())
    others: frozenset[str] = frozenset()

    @property
    def listed(self) -> list[Mode]:
        """Modes and lines by frequency."""
        return sorted((*self.modes, *self.harmonics), key=lambda mode: mode.frequency_hz)
