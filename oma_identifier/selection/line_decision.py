"""Which candidates are images of lines of machines and drives: one decision for all methods.

A pole is suspected where it has next to no damping, where it scatters less than the response to
random forces can, where the record is too short to see its bell, and where poles without damping
repeat over the model orders.  What is suspected is tested in the samples
(:mod:`oma_identifier.spectra.harmonics`).
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
import math
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from oma_identifier.selection.identified_band import IdentifiedBand
from oma_identifier.selection.thresholds import SELECTION
from oma_identifier.spectra import Line, SPECTRA

LineTest = Callable[[float, NDArray[np.complex128] | None], Line | None]
"""Frequency [Hz], and weights of the channels or None, to the line there; None where nothing is
known."""
SuspectTest = Callable[[float], Line | None]
"""The same that knows what to look at."""


class Candidate(Protocol):
    """What may be a mode."""

    @property
    def frequency_hz(self) -> float:
        """Natural frequency [Hz]."""

    @property
    def damping_ratio(self) -> float:
        """Damping ratio; NaN where a method knows none."""

    @property
    def is_too_certain(self) -> bool:
        """Whether it scatters less than the response to any random force allows."""

    @property
    def is_unresolved(self) -> bool:
        """Whether the record is too short to see its bell, so that it could be a line."""

    @property
    def line_reach(self) -> float:
        """Relative distance within which it may be the image of a line."""


@dataclass(frozen=True, slots=True)
class Suspect:
    """A frequency where a line may be.

    Parameters
    ----------
    frequency_hz : float [Hz]
        Where.
    chance : float
        Up to which noise may look like a line.
    least_odds : float
        Log odds of a line against a mode from where on it is a line.
    """

    frequency_hz: float
    chance: float = SPECTRA.line_chance
    least_odds: float = 0.0


def suspicious(candidates: Iterable[Candidate]) -> list[Suspect]:
    """Return the candidates that may be images of lines."""
    return [_suspect(each) for each in candidates if _is_sharp(each)]


def _suspect(candidate: Candidate) -> Suspect:
    if candidate.is_unresolved:
        return Suspect(candidate.frequency_hz, SPECTRA.sharp_line_chance, -SPECTRA.narrow_mode)
    return Suspect(
        candidate.frequency_hz,
        SPECTRA.sharp_line_chance if candidate.is_too_certain else SPECTRA.line_chance,
    )


def narrow(frequency_hz: float) -> Suspect:
    """Return a peak as narrow as a line; no pole asks for it, so it must be one for sure."""
    return Suspect(frequency_hz, SPECTRA.sharp_line_chance, SPECTRA.sure_line)


def undamped(of: IdentifiedBand) -> list[Suspect]:
    """Return the frequencies where poles with hardly any damping repeat over the orders."""
    poles, band = of.poles, of.band
    frequency, damping = poles.frequency_hz, np.abs(poles.damping_ratio)
    bare = np.flatnonzero(
        (damping < SPECTRA.suspect_damping)
        & (frequency > band.low_hz)
        & (frequency < band.high_hz)
    )
    if len(bare) == 0:
        return []
    bare = bare[np.argsort(frequency[bare])]
    apart = np.diff(frequency[bare]) > SELECTION.same_run * frequency[bare[:-1]]
    breaks = np.flatnonzero(apart) + 1
    least = max(SELECTION.fewest_line_orders, of.n_orders // SELECTION.line_orders)
    resolution_hz = 0.5 / of.duration_s
    suspects = []
    for run in np.split(bare, breaks):
        if len(run) < least:
            continue
        width_hz = float(np.median(damping[run] * frequency[run]))
        chance = SPECTRA.sharp_line_chance if width_hz < resolution_hz else SPECTRA.line_chance
        suspects.append(Suspect(float(np.median(frequency[run])), chance))
    return suspects


def lines_among(suspects: Iterable[Suspect], test_line: SuspectTest) -> list[Line]:
    """Return the lines that there are, by frequency."""
    lines: list[Line] = []
    for suspect in sorted(suspects, key=lambda suspect: suspect.frequency_hz):
        line = test_line(suspect.frequency_hz)
        if (
            line is not None
            and line.stands_out(suspect.chance, suspect.least_odds)
            and not _known(line, lines)
        ):
            lines.append(line)
    return lines


def is_shown(candidate: Candidate, test_line: SuspectTest) -> bool:
    """Tell whether a candidate whose bell is too narrow to be seen is shown to be a mode."""
    if not candidate.is_unresolved:
        return True
    line = test_line(candidate.frequency_hz)
    return line is not None and line.is_mode


def is_line(candidate: Candidate, lines: Sequence[Line]) -> bool:
    """Tell whether a candidate is the image of a line: as sharp or as certain, at its place."""
    reach = float(np.fmax(candidate.line_reach, candidate.damping_ratio))
    return _is_sharp(candidate) and any(
        abs(line.frequency_hz / candidate.frequency_hz - 1.0) < reach for line in lines
    )


def _is_sharp(candidate: Candidate) -> bool:
    # NaN, where a method knows no damping, may be a line.
    sharp = not candidate.damping_ratio >= SELECTION.sharp
    return sharp or candidate.is_too_certain or candidate.is_unresolved


def _known(line: Line, lines: Sequence[Line]) -> bool:
    return any(is_same_line(line.frequency_hz, other.frequency_hz) for other in lines)


def line_reach(frequency_hz: float, duration_s: float, widest: float) -> float:
    """Return the relative distance within which images of a line lie, widest if it wavers."""
    return min(widest, SPECTRA.sidebands / (frequency_hz * duration_s))


def is_same_line(first_hz: float, second_hz: float) -> bool:
    """Tell whether two frequencies are views of one line."""
    return math.isclose(first_hz, second_hz, rel_tol=SELECTION.same_line)
