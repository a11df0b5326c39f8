"""What was identified of one stretch, and what is taken out of it again."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
import logging

import numpy as np

from modal_core.indicators import mpc, mpd, normalise
from modal_core.mode import Mode, ModeSet
from modal_core.poles import PoleStatus, PoleTable
from modal_core.samples import Samples
from oma_identifier.spectra import Line, LineEvidence

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Identified:
    """Modes and poles of one stretch.

    Parameters
    ----------
    modes, harmonics : ModeSet
        Of the structure; of machines and drives.
    poles : PoleTable
        All poles; ``mode_id`` is the position in ``modes``, counted from 1.
    is_undecided : bool
        Whether a harmonic may be a mode of light damping.
    """

    modes: ModeSet
    harmonics: ModeSet
    poles: PoleTable
    is_undecided: bool = False


def line_evidence(samples: Samples, found: Identified) -> LineEvidence:
    """Return what tells the modes found in samples from the leakage of lines."""
    return LineEvidence.of(samples, tuple(found.harmonics.frequency_hz), found.modes)


def without_explained(
    found: Identified, evidence: LineEvidence | None, *, anywhere: bool = False
) -> Identified:
    """Return what was found without the modes that lines explain.

    Parameters
    ----------
    found : Identified
        Of the stretch that the evidence is of, or a longer one.
    evidence : LineEvidence or None
        None: there are no lines.
    anywhere : bool
        As for :meth:`LineEvidence.explains`.
    """
    if evidence is None:
        return found
    kept = [
        index
        for index, mode in enumerate(found.modes)
        if not evidence.explains(mode, anywhere=anywhere)
    ]
    if len(kept) == len(found.modes):
        return found
    for index, mode in enumerate(found.modes):
        if index not in kept:
            log.debug('%.4g Hz: lines explain it', mode.frequency_hz)
    return _kept(found, kept)


def without_modes(found: Identified) -> Identified:
    """Return what was found as if lines explained all of its modes."""
    return _kept(found, [])


def _kept(found: Identified, kept: Sequence[int]) -> Identified:
    modes = replace(found.modes, modes=tuple(found.modes.modes[index] for index in kept))
    poles = renumbered(found.poles, kept)
    status = poles.status.copy()
    status[(found.poles.mode_id > 0) & (poles.mode_id == 0)] = PoleStatus.HARMONIC
    return replace(found, modes=modes, poles=replace(poles, status=status))


def with_lines(found: Identified, lines: Sequence[Mode]) -> Identified:
    """Return what was found with further harmonics, by frequency."""
    if not lines:
        return found
    merged = sorted((*found.harmonics, *lines), key=lambda line: line.frequency_hz)
    return replace(found, harmonics=replace(found.harmonics, modes=tuple(merged)))


def harmonic(line: Line) -> Mode:
    """Return a line as a mode without damping, marked harmonic."""
    shape = normalise(line.shape)
    return Mode(
        frequency_hz=line.frequency_hz,
        damping_ratio=0.0,
        shape=shape,
        mpc=float(mpc(shape[:, None])[0]),
        mpd=float(mpd(shape[:, None])[0]),
        harmonic=True,
    )


def no_poles(n_channels: int) -> PoleTable:
    """Return an empty table."""
    return PoleTable(
        np.empty(0, dtype=np.int64),
        np.empty(0, dtype=complex),
        np.empty((n_channels, 0), dtype=complex),
        np.empty(0, dtype=np.uint8),
        np.empty(0, dtype=np.int64),
    )


def renumbered(poles: PoleTable, origin: Sequence[int]) -> PoleTable:
    """Return the poles with the numbers that their modes have now; new modes have no poles."""
    number = np.zeros(max(0, poles.mode_id.max(initial=0), *origin) + 2, dtype=np.int64)
    for now, before in enumerate(origin, start=1):
        if before >= 0:
            number[before + 1] = now
    return replace(poles, mode_id=number[poles.mode_id])
