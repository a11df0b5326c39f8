"""Set-up check of accelerometers against gravity: the one quantity every sensor knows.

A sensor with three axes at rest reads 9.81 m/s², whatever its mounting.  One that reads 1 sends g
instead of m/s²; a length nearer to half or twice is a wrong gain.  Sensors without a constant part
(AC-coupled, or with gravity taken out) say nothing, offset or not.  What is found is a suggestion
for a person: nothing is corrected.
"""

from collections.abc import Sequence
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.channel import Channel
from modal_core.units import ACCELERATION, STANDARD_GRAVITY
from oma_identifier.quality.thresholds import QUALITY

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
    lengths = {
        tuple(axes.values()): float(np.linalg.norm(mean[list(axes.values())]))
        for axes in sensors.values()
        if len(axes) == 3
    }
    # Beside sensors without a constant part, 1 m/s² may be the offset of another one.
    has_gravity = all(length >= 1.0 - QUALITY.g_error for length in lengths.values())
    flags = {axes: _flag(length, has_gravity) for axes, length in lengths.items()}
    return {channels[place].name: flag for axes, flag in flags.items() if flag for place in axes}


def _flag(length_m_s2: float, has_gravity: bool) -> str:
    if abs(length_m_s2 - 1.0) <= QUALITY.g_error:
        return UNIT_G if has_gravity else ''
    wrong = abs(math.log(max(length_m_s2, QUALITY.least_gravity_m_s2) / STANDARD_GRAVITY))
    return (
        GRAVITY
        if length_m_s2 >= QUALITY.least_gravity_m_s2 and wrong > math.log(QUALITY.least_factor)
        else ''
    )
