"""The selections of all bands joined: modes, lines and one table of poles."""

from collections.abc import Sequence
from functools import cache
import logging

import numpy as np

from modal_core.channel import Channel
from modal_core.indicators import mpc, mpd, normalise
from modal_core.mode import Mode, ModeSet
from modal_core.poles import PoleStatus, PoleTable
from oma_identifier.motion import PeakTest
from oma_identifier.selection.identified import harmonic, Identified, no_poles
from oma_identifier.selection.line_decision import (
    is_line,
    is_shown,
    lines_among,
    LineTest,
    SHARP,
    SuspectTest,
    suspicious,
    undamped,
)
from oma_identifier.selection.modal_filter import FilteredLineTest
from oma_identifier.selection.selection import BandSelection, SelectedPole, without_repeats
from oma_identifier.spectra import Line, SUSPECT_DAMPING

log = logging.getLogger(__name__)


def join_bands(
    selections: Sequence[BandSelection],
    channels: Sequence[Channel],
    method: str,
    test_line: LineTest,
    explains: PeakTest,
) -> Identified:
    """Join the bands, and sort out what lines and the robot's motion explain.

    Parameters
    ----------
    selections : sequence of BandSelection
        One per band that has poles.
    channels : sequence of Channel
        Of the samples.
    method : str
        By which the poles were identified.
    test_line : callable
        Frequency [Hz] and weights of the channels, or None, to the line there; None where nothing
        can be said.
    explains : callable
        Tells a peak that motion of the robot explains from a mode.
    """
    names = tuple(channel.name for channel in channels)
    poles = without_repeats([pole for each in selections for pole in each.selected])
    bands = [each.band for each in selections]
    suspects = suspicious(poles)
    for band in bands:
        suspects += undamped(band)
    # A suspect that is no line may be asked for once more, whether it is a mode.
    test = cache(FilteredLineTest(test_line, poles, bands).line_at)
    lines = lines_among(suspects, test)
    kept = [pole for pole in poles if _is_mode(pole, lines, test, explains)]
    modes = ModeSet(tuple(_mode(pole) for pole in kept), names, method)
    harmonics = ModeSet(tuple(harmonic(line) for line in lines), names, method)
    table = _table(selections, kept, lines, len(names))
    return Identified(modes, harmonics, table, any(line.is_doubtful for line in lines))


def _is_mode(
    pole: SelectedPole,
    lines: Sequence[Line],
    test_line: SuspectTest,
    explains: PeakTest,
) -> bool:
    width_hz = pole.damping_ratio * pole.frequency_hz
    if is_line(pole, lines):
        log.debug('%.4g Hz: the image of a line', pole.frequency_hz)
    elif not is_shown(pole, test_line):
        log.debug('%.4g Hz: too narrow to be seen, and not shown to be a mode', pole.frequency_hz)
    elif explains(pole.frequency_hz, width_hz, pole.physical_shape):
        log.debug("%.4g Hz: the robot's own motion explains it", pole.frequency_hz)
    else:
        return True
    return False


def _mode(pole: SelectedPole) -> Mode:
    shape = normalise(pole.physical_shape)
    return Mode(
        frequency_hz=pole.frequency_hz,
        damping_ratio=pole.damping_ratio,
        shape=shape,
        frequency_std_hz=pole.deviation.frequency_std_hz,
        damping_ratio_std=pole.damping_ratio_std,
        mpc=float(mpc(pole.shape[:, None])[0]),
        mpd=float(mpd(pole.shape[:, None])[0]),
    )


def _table(
    selections: Sequence[BandSelection],
    kept: Sequence[SelectedPole],
    lines: Sequence[Line],
    n_channels: int,
) -> PoleTable:
    """Join the poles of all bands; poles outside a band's own range are left to its neighbour."""
    orders, poles, shapes, status, ids = [], [], [], [], []
    for each in selections:
        table = each.band.poles
        verdict = each.status.copy()
        mode_id = np.zeros(len(verdict), dtype=np.int64)
        verdict[verdict == PoleStatus.KEPT] = PoleStatus.CLUSTER_OUTLIER
        for number, pole in enumerate(kept, start=1):
            if pole.band is each.band:
                mode_id[pole.cluster.members] = number
                verdict[pole.cluster.members] = PoleStatus.KEPT
        for line in lines:
            near = np.abs(table.frequency_hz / line.frequency_hz - 1.0) < SUSPECT_DAMPING
            near &= np.abs(table.damping_ratio) < SHARP
            verdict[near & (mode_id == 0)] = PoleStatus.HARMONIC
        inside = verdict != PoleStatus.OUT_OF_BAND
        orders.append(table.model_order[inside])
        poles.append(table.pole[inside])
        shapes.append(table.shape[:, inside] * each.band.scale[:, None])
        status.append(verdict[inside])
        ids.append(mode_id[inside])
    if not selections:
        return no_poles(n_channels)
    return PoleTable(
        np.concatenate(orders),
        np.concatenate(poles),
        np.concatenate(shapes, axis=1),
        np.concatenate(status),
        np.concatenate(ids),
    )
