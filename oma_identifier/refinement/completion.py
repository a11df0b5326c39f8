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
from oma_identifier.refinement.mode_evidence import is_demanded, missing_mode, MissingMode
from oma_identifier.refinement.refining import Refining
from oma_identifier.refinement.thresholds import REFINEMENT

log = logging.getLogger(__name__)


def add_missing(of: Refining) -> Refining:
    """Add modes that are missing, one by one, as long as that mends the bands that lack one."""
    for _ in range(REFINEMENT.most_missing):
        wider = _with_one_more(of)
        if wider is None:
            break
        of = wider
    return of


def add_candidates(of: Refining) -> Refining:
    """Add candidates that the data demand, one by one, the least damped first."""
    for each in sorted(of.record.candidates, key=lambda mode: mode.damping_ratio):
        of = _mended(of, of.record.start_of([each]), REFINEMENT.adopted_misfit) or of
    return of


def _with_one_more(of: Refining) -> Refining | None:
    """Return the modes with the one that is missing most, None where none mends its band."""
    lacking = [each for each in of.fits if REFINEMENT.incomplete_misfit < each.misfit < math.inf]
    found = [(mode, each) for each in lacking if (mode := missing_mode(each)) is not None]
    found.sort(key=lambda pair: pair[0].rise, reverse=True)
    tried = (_mended(of, _start(mode), source.misfit) for mode, source in found)
    return next((wider for wider in tried if wider is not None), None)


def _mended(of: Refining, mode: StartModes, misfit: float) -> Refining | None:
    """Return the modes with a further one; None where its band has a larger misfit with it."""
    wider, new = _joined(of.now, mode), ModeIndex(len(of.now.frequency_hz))
    groups = group_modes(wider, of.record.spectra.spacing_hz)
    own = next(group for group in groups if new in group)
    # The other bands matter only once the mode's own is mended.
    (mended,) = of.fitter.fit(wider, [own])
    if not (mended.misfit < misfit and is_demanded(mended, mended.position(new))):
        log.debug('%.4g Hz: a mode more does not mend its band', mode.frequency_hz[0])
        return None
    log.debug('%.4g Hz: a mode was missing', mode.frequency_hz[0])
    good = [each for each in of.fits if each.misfit <= REFINEMENT.incomplete_misfit]
    fits = of.fitter.fit(wider, groups, known=[*good, mended], convergence=LATER_PASS)
    return replace(of, now=updated(wider, fits), fits=tuple(fits))


def demanded(of: Refining) -> dict[ModeIndex, GroupFit]:
    """Return the modes beyond those given that the data demand, with their fits."""
    return {
        mode: each
        for each in of.fits
        for position, mode in each.members()
        if mode >= of.n_given
        and each.misfit < REFINEMENT.accepted_misfit
        and is_demanded(each, position)
    }


def _start(mode: MissingMode) -> StartModes:
    return StartModes(
        np.array([mode.frequency_hz]), np.array([mode.damping_ratio]), mode.shape[:, None]
    )


def _joined(now: StartModes, mode: StartModes) -> StartModes:
    return StartModes(
        np.append(now.frequency_hz, mode.frequency_hz),
        np.append(now.damping_ratio, mode.damping_ratio),
        np.column_stack([now.shapes, mode.shapes]),
    )
