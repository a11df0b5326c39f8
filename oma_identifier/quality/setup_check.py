"""Set-up check of accelerometers against gravity: the one quantity every sensor knows.

A sensor with three axes at rest reads 9.81 m/s², whatever its mounting.  One that reads 1 sends g
instead of m/s²; another length is a wrong gain.  Sensors without a constant part (AC-coupled, or
with gravity taken out) say nothing.  What is found is a suggestion for a person: nothing is
corrected.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from modal_core.channel import ACCELERATION, Channel

STANDARD_GRAVITY_M_S2 = 9.80665
LARGEST_ERROR = 0.1
"""Share by which the length of gravity may be off: calibration, and motion that does not end."""
LEAST_M_S2 = 0.3
"""Below, a sensor has no constant part."""
UNIT_G = 'unit_g_suspicion'
GRAVITY = 'gravity_suspicion'


def check_gravity(channels: Sequence[Channel], mean: NDArray[np.float64]) -> dict[str, str]:
    """Return a flag per channel of every sensor whose gravity has the wrong length.

    Parameters
    ----------
    channels : sequence of Channel
        One per column; the axes of a sensor are called ``<sensor>.x``, ``.y`` and ``.z``.
    mean : (n_channels,) array [m/s²]
        Over one window.
    """
    sensors: dict[str, dict[str, int]] = {}
    for place, channel in enumerate(channels):
        name, _, axis = channel.name.rpartition('.')
        if name and axis in ('x', 'y', 'z') and channel.unit == ACCELERATION:
            sensors.setdefault(name, {})[axis] = place
    found = {}
    for axes in sensors.values():
        if len(axes) == 3:
            flag = _flag(float(np.linalg.norm(mean[list(axes.values())])))
            found.update({channels[place].name: flag for place in axes.values() if flag})
    return found


def _flag(length_m_s2: float) -> str:
    if length_m_s2 < LEAST_M_S2:
        return ''
    if abs(length_m_s2 / STANDARD_GRAVITY_M_S2 - 1.0) <= LARGEST_ERROR:
        return ''
    return UNIT_G if abs(length_m_s2 - 1.0) <= LARGEST_ERROR else GRAVITY
