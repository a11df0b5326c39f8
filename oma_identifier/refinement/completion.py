"""Modes that the likelihood finds missing, taken in as long as they mend their bands."""

from collections.abc import Sequence
import math

import numpy as np

from oma_identifier.likelihood import group_modes, GroupFit, IMPATIENT, StartModes, updated
from oma_identifier.refinement.band_fitter import BandFitter
from oma_identifier.refinement.mode_evidence import is_demanded, missing_mode, MissingMode
from oma_identifier.refinement.relabelling import relabelled
from oma_identifier.refinement.verdict import LARGEST_MISFIT

INCOMPLETE_MISFIT = 1.2
"""From here on a band may lack a mode."""
MOST_MISSING = 2


def completed(
    fitter: BandFitter, now: StartModes, fits: list[GroupFit], start: StartModes
) -> tuple[StartModes, list[GroupFit], dict[int, GroupFit]]:
    """Add modes that are missing, one by one, as long as that mends the bands that lack one.

    Parameters
    ----------
    fitter : BandFitter
        Of the record.
    now, fits : StartModes and list of GroupFit
        All modes as refined so far.
    start : StartModes
        Those that were given, as they came.

    Returns
    -------
    tuple
        The modes, their fits, and those beyond the given ones that the data demand.
    """
    n_given = len(start.frequency_hz)
    before = now, fits
    for _ in range(MOST_MISSING):
        lacking = [each for each in fits if INCOMPLETE_MISFIT < each.misfit < math.inf]
        found = [(mode, each) for each in lacking if (mode := missing_mode(each)) is not None]
        if not found:
            break
        mode, source = max(found, key=lambda pair: pair[0].rise)
        wider = _appended(now, mode)
        groups = group_modes(wider)
        own = next(group for group in groups if len(now.frequency_hz) in group)
        # The other bands matter only once the mode's own is mended.
        (mended,) = fitter.fit(wider, [own])
        added = mended.group.index(len(now.frequency_hz))
        if not (mended.misfit < source.misfit and is_demanded(mended, added)):
            break
        good = [each for each in fits if each.misfit <= INCOMPLETE_MISFIT]
        more = fitter.fit(wider, groups, known=[*good, mended], patience=IMPATIENT)
        now, fits = updated(wider, more), more
    if fits is not before[1]:
        now, fits = fitter.again(now, fits)
        now, fits = relabelled(now, fits, start)
    demanded = _demanded(fits, n_given)
    if not any(mode >= len(before[0].frequency_hz) for mode in demanded):
        return *before, _demanded(before[1], n_given)
    return now, fits, demanded


def _demanded(fits: Sequence[GroupFit], n_given: int) -> dict[int, GroupFit]:
    return {
        mode: each
        for each in fits
        for position, mode in enumerate(each.group)
        if mode >= n_given and each.misfit < LARGEST_MISFIT and is_demanded(each, position)
    }


def _appended(now: StartModes, mode: MissingMode) -> StartModes:
    return StartModes(
        np.append(now.frequency_hz, mode.frequency_hz),
        np.append(now.damping_ratio, mode.damping_ratio),
        np.column_stack([now.shapes, mode.shape]),
    )
