"""The colour of the force about a mode: the power of frequency that its power goes with.

Flanks of a peak tell it.  A structure that is shaken through its base has one: over ground a mode
accelerates by ω₀² / (ω₀² - ω²) of what the base does, and under a force by ω² / (ω₀² - ω²) of what
the force would; so the power of the one is (ω₀ / ω)⁴ of that of the other, a colour of -4.
What a filter leaves of other modes that move in step looks to first order like a colour, too:
|H + ε|² is |H|² (1 + 2 ε (ω₀² - ω²)), H the mode's displacement and ω₀ its own frequency.
"""

from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np

from oma_identifier.levels.envelope import Peak
from oma_identifier.levels.thresholds import LEVELS


@dataclass(frozen=True, slots=True)
class Colour:
    """Exponent of frequency that the power of the force goes with, and its standard deviation."""

    exponent: float
    std: float


def common_colour(levels: Sequence[tuple[float, Peak]]) -> Colour:
    """Return the colour that levels share.

    A peak that its level bends has flanks of its own; so those count that are about where the
    smallest has its peak.

    Parameters
    ----------
    levels : sequence of (float, Peak)
        Mean square of the motion and coloured peak of each.
    """
    smallest = min(levels, key=lambda each: each[0])[1]
    near_hz = LEVELS.straight * smallest.half_width_hz
    peaks = [each for _, each in levels if abs(each.centre_hz - smallest.centre_hz) <= near_hz]
    value, std = np.array([(each.colour, each.colour_std) for each in peaks]).T
    precision = std**-2.0
    mean = float(precision @ value / precision.sum())
    scatter = float(precision @ (value - mean) ** 2) / max(len(value) - 1, 1)
    precision /= max(1.0, scatter)
    total = float(precision.sum()) + LEVELS.colour**-2.0
    return Colour(float(precision @ value) / total, 1.0 / math.sqrt(total))
