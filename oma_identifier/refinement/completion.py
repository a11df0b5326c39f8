"""Modes that the likelihood finds missing, taken in as long as they mend their bands."""

from dataclasses import replace
import logging
import math

import numpy as np

from oma_identifier.likelihood import (
    group_modes,
    GroupFit,
    LATER_PASS,
    ModeIndex,
    StartModes,
    updated,
)
from oma_identifier.refinement.acceptance import LIMITS
from oma_identifier.refinement.mode_evidence import is_demanded, missing_mode, MissingMode
from oma_identifier.refinement.refining import Refining

INCOMPLETE_MISFIT = 1.2
"""From here on a band may lack a mode."""
MOST_MISSING = 2

log = logging.getLogger(__name__)


def add_missing(of: Refining) -> Refining:
    """Add modes that are missing, one by one, as long as that mends the bands that lack one."""
    for _ in range(MOST_MISSING):
        wider = _with_one_more(of)
        if wider is None:
            break
        of = wider
    return of


def _with_one_more(of: Refining) -> Refining | None:
    """Return the modes with the one that is missing most, None where none mends its band."""
    lacking = [each for each in of.fits if INCOMPLETE_MISFIT < each.misfit < math.inf]
    found = [(mode, each) for each in lacking if (mode := missing_mode(each)) is not None]
    if not found:
        return None
    mode, source = max(found, key=lambda pair: pair[0].rise)
    wider, new = _appended(of.now, mode), ModeIndex(len(of.now.frequency_hz))
    groups = group_modes(wider)
    own = next(group for group in groups if new in group)
    # The other bands matter only once the mode's own is mended.
    (mended,) = of.fitter.fit(wider, [own])
    if not (mended.misfit < source.misfit and is_demanded(mended, mended.position(new))):
        log.debug('%.4g Hz: a mode more does not mend its band', mode.frequency_hz)
        return None
    log.debug('%.4g Hz: a mode was missing', mode.frequency_hz)
    good = [each for each in of.fits if each.misfit <= INCOMPLETE_MISFIT]
    fits = of.fitter.fit(wider, groups, known=[*good, mended], convergence=LATER_PASS)
    return replace(of, now=updated(wider, fits), fits=tuple(fits))


def demanded(of: Refining) -> dict[ModeIndex, GroupFit]:
    """Return the modes beyond those given that the data demand, with their fits."""
    return {
        mode: each
        for each in of.fits
        for position, mode in each.members()
        if mode >= of.n_given
        and each.misfit < LIMITS.largest_misfit
        and is_demanded(each, position)
    }


def _appended(now: StartModes, mode: MissingMode) -> StartModes:
    return StartModes(
        np.append(now.frequency_hz, mode.frequency_hz),
        np.append(now.damping_ratio, mode.damping_ratio),
        np.column_stack([now.shapes, mode.shape]),
    )
