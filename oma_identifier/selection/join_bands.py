"""The selections of all bands joined: modes, lines and one table of poles."""

from collections.abc import Sequence
from functools import cache
import logging

import numpy as np

from modal_core.channel import Channel
from modal_core.mode import Mode, ModeSet
from modal_core.numbers.indicators import mpc, mpd, normalise
from modal_core.poles import PoleStatus, PoleTable
from oma_identifier.motion import PeakTest
from oma_identifier.selection.distinct import without_repeats
from oma_identifier.selection.identified import harmonic, Identified, no_poles
from oma_identifier.selection.line_decision import (
    is_line,
    is_shown,
    lines_among,
    LineTest,
    narrow,
    SuspectTest,
    suspicious,
    undamped,
)
from oma_identifier.selection.modal_filter import FilteredLineTest
from oma_identifier.selection.selected_pole import SelectedPole
from oma_identifier.selection.selection import BandSelection
from oma_identifier.selection.thresholds import SELECTION
from oma_identifier.spectra import Line, SPECTRA

log = logging.getLogger(__name__)


def join_bands(
    selections: Sequence[BandSelection],
    channels: Sequence[Channel],
    method: str,
    test_line: LineTest,
    explains: PeakTest,
    narrow_hz: Sequence[float] = (),
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
    narrow_hz : sequence of float [Hz]
        Where the spectrum peaks as narrowly as that of a line.
    """
    names = tuple(channel.name for channel in channels)
    poles = without_repeats([pole for each in selections for pole in each.selected])
    bands = [each.band for each in selections]
    suspects = [*suspicious(poles), *map(narrow, narrow_hz)]
    for band in bands:
        suspects += undamped(band)
    # A suspect that is no line may be asked for once more, whether it is a mode.
    test = cache(FilteredLineTest(test_line, poles, bands).line_at)
    lines = lines_among(suspects, test)
    kept = [pole for pole in poles if _is_mode(pole, lines, test, explains)]
    modes = ModeSet(tuple(mode_of(pole) for pole in kept), names, method)
    harmonics = ModeSet(tuple(harmonic(line) for line in lines), names, method)
    table = _table(selections, kept, lines, len(names))
    doubtful_hz = tuple(line.frequency_hz for line in lines if line.is_doubtful)
    return Identified(modes, harmonics, table, doubtful_hz)


def _is_mode(
    pole: SelectedPole,
    lines: Sequence[Line],
    test_line: SuspectTest,
    explains: PeakTest,
) -> bool:
    if is_line(pole, lines):
        log.debug(
            '%.4g Hz: the image of a line, damped by %.2g of critical',
            pole.frequency_hz,
            pole.damping_ratio,
        )
    elif not is_shown(pole, test_line):
        log.debug(
            '%.4g Hz: its bell of %.2g Hz is too narrow to be seen, and not shown to be a mode',
            pole.frequency_hz,
            pole.half_width_hz,
        )
    elif explains(pole.frequency_hz, pole.half_width_hz, pole.physical_shape):
        log.debug("%.4g Hz: the robot's own motion explains it", pole.frequency_hz)
    else:
        return True
    return False


def mode_of(pole: SelectedPole) -> Mode:
    """Return a pole as a mode."""
    shape = normalise(pole.physical_shape)
    return Mode(
        frequency_hz=pole.frequency_hz,
        damping_ratio=pole.freed_damping_ratio,
        shape=shape,
        frequency_std_hz=pole.frequency_std_hz,
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
            near = np.abs(table.frequency_hz / line.frequency_hz - 1.0) < SPECTRA.suspect_damping
            near &= np.abs(table.damping_ratio) < SELECTION.sharp
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
