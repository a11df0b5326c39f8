"""Label switching: which fitted mode is which of the modes that a refinement was given.

A fit may lead a mode to the place of one that was missing, and a stand-in for that to the place
it left.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from modal_core.numbers.assignment import cheapest_pairs
from modal_core.numbers.indicators import mac
from oma_identifier.likelihood import GroupFit, ModeIndex, StartModes

FARTHEST = 10.0
"""Distance in half-power half-widths from where on it makes no difference how far it is."""


def undo_label_switching(
    now: StartModes, fits: Sequence[GroupFit], start: StartModes
) -> tuple[StartModes, list[GroupFit]]:
    """Give each mode that was there from the start the fitted one that is most like it.

    Parameters
    ----------
    now : StartModes
        All modes, those added since the start after the others.
    fits : sequence of GroupFit
        Of their groups.
    start : StartModes
        As they came.
    """
    place = np.arange(len(now.frequency_hz))
    result = []
    for each in fits:
        labels = _labels(now, each, start)
        place[labels] = each.group
        result.append(replace(each, group=labels))
    moved = StartModes(now.frequency_hz[place], now.damping_ratio[place], now.shapes[:, place])
    return moved, result


def _labels(now: StartModes, each: GroupFit, start: StartModes) -> list[ModeIndex]:
    """Return the mode at each position of a group."""
    given = [mode for mode in each.group if mode < len(start.frequency_hz)]
    if each.fit is None or not given or len(each.group) < 2:
        return each.group
    width = start.half_width_hz[given, None]
    apart = np.abs(start.frequency_hz[given, None] - now.frequency_hz[each.group]) / width
    wider = np.abs(start.half_width_hz[given, None] - now.half_width_hz[each.group]) / width
    unlike = 1.0 - mac(start.shapes[:, given], now.shapes[:, each.group])
    distance = np.minimum(np.hypot(apart, wider), FARTHEST) + unlike
    rows, positions = cheapest_pairs(distance)
    known = {int(at): given[row] for row, at in zip(rows, positions, strict=True)}
    others = iter(mode for mode in each.group if mode not in given)
    return [known[at] if at in known else next(others) for at in range(len(each.group))]
