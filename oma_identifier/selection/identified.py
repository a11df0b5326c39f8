"""What was identified of one stretch, and what is taken out of it again."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
import logging

import numpy as np
from numpy.typing import NDArray

from modal_core.mode import Mode, ModeSet
from modal_core.numbers.indicators import mpc, mpd, normalise
from modal_core.poles import PoleStatus, PoleTable
from modal_core.samples import Samples
from oma_identifier.spectra import Line, LineEvidence, SpectralPeaks

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
    doubtful_hz : tuple of float [Hz]
        Harmonics that may be modes of light damping.
    n_conditions : int
        Loading conditions that were told apart, by a method that compares them; else 0.
    """

    modes: ModeSet
    harmonics: ModeSet
    poles: PoleTable
    doubtful_hz: tuple[float, ...] = ()
    n_conditions: int = 0

    @property
    def sure_lines_hz(self) -> NDArray[np.float64]:
        """Frequencies of the harmonics that are no modes for sure [Hz]."""
        return np.setdiff1d(self.harmonics.frequency_hz, self.doubtful_hz)


def nothing_in(samples: Samples, method: str) -> Identified:
    """Return that nothing was found in samples."""
    none = ModeSet((), samples.channel_names, method)
    return Identified(none, none, no_poles(len(samples.channels)))


def line_evidence(samples: Samples, found: Identified) -> LineEvidence:
    """Return what tells the modes found in samples from the leakage of lines."""
    return LineEvidence.of(samples, tuple(found.sure_lines_hz), found.modes)


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
    return only(found, kept)


def without_modes(found: Identified) -> Identified:
    """Return what was found as if lines explained all of its modes."""
    return only(found, [])


def without_moments(found: Identified, peaks: SpectralPeaks) -> Identified:
    """Return what was found without modes that few loud moments show, and the others do not."""
    kept = []
    for index, mode in enumerate(found.modes):
        if peaks.is_of_moments(mode.frequency_hz, mode.damping_ratio * mode.frequency_hz):
            log.debug('%.4g Hz: a peak of few loud moments', mode.frequency_hz)
        else:
            kept.append(index)
    return found if len(kept) == len(found.modes) else only(found, kept, PoleStatus.UNCERTAIN)


def only(
    found: Identified, kept: Sequence[int], why: PoleStatus = PoleStatus.HARMONIC
) -> Identified:
    """Return what was found with some of its modes; the poles of the others say why not."""
    modes = replace(found.modes, modes=tuple(found.modes.modes[index] for index in kept))
    poles = renumbered(found.poles, kept)
    status = poles.status.copy()
    status[(found.poles.mode_id > 0) & (poles.mode_id == 0)] = why
    return replace(found, modes=modes, poles=replace(poles, status=status))


def up_to(found: Identified, highest_hz: float) -> Identified:
    """Return what was found up to a frequency [Hz]."""
    kept = [i for i, mode in enumerate(found.modes) if mode.frequency_hz <= highest_hz]
    lines = tuple(line for line in found.harmonics if line.frequency_hz <= highest_hz)
    poles = renumbered(found.poles, kept)
    return replace(
        found,
        modes=replace(found.modes, modes=tuple(found.modes.modes[index] for index in kept)),
        harmonics=replace(found.harmonics, modes=lines),
        poles=poles.chosen(poles.frequency_hz <= highest_hz),
    )


def with_lines(found: Identified, lines: Sequence[Mode]) -> Identified:
    """Return what was found with further harmonics, by frequency."""
    if not lines:
        return found
    merged = sorted((*found.harmonics, *lines), key=lambda line: line.frequency_hz)
    return replace(found, harmonics=replace(found.harmonics, modes=tuple(merged)))


def with_forced(found: Identified, forced: Sequence[Mode]) -> Identified:
    """Return what was found with peaks of narrow-band forces, as harmonics in doubt.

    A longer record tells them from modes still better.
    """
    hz = {*found.doubtful_hz, *(mode.frequency_hz for mode in forced)}
    lines = [replace(mode.untold, damping_ratio=0.0, harmonic=True) for mode in forced]
    return with_lines(replace(found, doubtful_hz=tuple(sorted(hz))), lines)


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
