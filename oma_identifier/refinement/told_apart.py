"""Modes of one shape that overlap: the likelihood must have told them apart.

A natural frequency that moves during the record, or a force that is not white, makes two stable
poles of one mode.  Where a likelihood describes the band it decides; where it does not, nothing
speaks for a second mode.
"""

from collections.abc import Sequence
import math

import numpy as np
from scipy.stats import beta

from modal_core.mode import Mode
from modal_core.numbers.indicators import mac
from oma_identifier.likelihood import overlaps
from oma_identifier.refinement.thresholds import REFINEMENT


def repeated(modes: Sequence[Mode]) -> set[int]:
    """Return the modes, by position, that are another one once more as far as anyone knows.

    Of two that were not both refined the one that is less well determined.
    """
    if len(modes) < 2 or _chance(len(modes[0].shape)) > REFINEMENT.repeated_chance:
        return set()
    frequency = np.array([mode.frequency_hz for mode in modes])
    width = frequency * [mode.damping_ratio for mode in modes]
    shapes = np.column_stack([mode.shape for mode in modes])
    alike = overlaps(frequency, width) & (mac(shapes, shapes) > REFINEMENT.repeated_mac)
    left_out: set[int] = set()
    for place in sorted(range(len(modes)), key=lambda at: _doubt(modes[at])):
        if math.isfinite(modes[place].mac_loss):
            continue
        better = set(np.flatnonzero(alike[place]).tolist()) - left_out - {place}
        if any(_doubt(modes[other]) < _doubt(modes[place]) for other in better):
            left_out.add(place)
    return left_out


def _chance(n_channels: int) -> float:
    """Return the share of unrelated real shapes that are as alike as one mode's."""
    return float(beta.sf(REFINEMENT.repeated_mac, 0.5, 0.5 * (n_channels - 1)))


def _doubt(mode: Mode) -> tuple[bool, float]:
    """Return what rises from refined modes to those whose frequency is determined worst."""
    return not math.isfinite(mode.mac_loss), mode.frequency_std_hz
