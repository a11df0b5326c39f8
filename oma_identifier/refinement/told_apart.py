"""Modes of one shape that overlap: the likelihood must have told them apart.

A natural frequency that moves during the record, or a force that is not white, makes two stable
poles of one mode.  Where a likelihood describes the band it decides; where it does not, nothing
speaks for a second mode.
"""

from collections.abc import Sequence
import math

import numpy as np
from scipy.stats import beta

from modal_core.indicators import mac
from modal_core.mode import Mode
from oma_identifier.likelihood import overlaps

SAME_MAC = 0.95
BY_CHANCE = 0.01
"""Largest share of unrelated real shapes that may be so alike: four channels or more tell."""


def repeated(modes: Sequence[Mode]) -> set[int]:
    """Return the modes, by position, that are another one once more as far as anyone knows.

    Of two that were not both refined the one that is less well determined.
    """
    if len(modes) < 2 or beta.sf(SAME_MAC, 0.5, 0.5 * (len(modes[0].shape) - 1)) > BY_CHANCE:
        return set()
    frequency = np.array([mode.frequency_hz for mode in modes])
    width = frequency * [mode.damping_ratio for mode in modes]
    shapes = np.column_stack([mode.shape for mode in modes])
    alike = overlaps(frequency, width) & (mac(shapes, shapes) > SAME_MAC)
    left_out: set[int] = set()
    for place in sorted(range(len(modes)), key=lambda at: _doubt(modes[at])):
        if math.isfinite(modes[place].mac_loss):
            continue
        better = set(np.flatnonzero(alike[place]).tolist()) - left_out - {place}
        if any(_doubt(modes[other]) < _doubt(modes[place]) for other in better):
            left_out.add(place)
    return left_out


def _doubt(mode: Mode) -> tuple[bool, float]:
    """Return what rises from refined modes to those whose frequency is determined worst."""
    return not math.isfinite(mode.mac_loss), mode.frequency_std_hz
