"""Whether there is response at a mode that lines do not explain.

Between lines a covariance of finite length holds their leakage and their products, and a subspace
method finds well determined poles to describe it.  So every line is fitted to the samples and
taken out: a mode must stand above the floor in what is left.  The floor at a mode is the median
power on either flank, the lower of both; noise without any mode passes with ``CHANCE``.  Where
the lines take next to nothing out of a mode's band they explain nothing of it: it is not tested,
unless the method makes modes of peaks of noise.

References
----------
Thomson (1982), doi:10.1109/PROC.1982.12433, Section XIII (lines first, then the rest).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
import math

import numpy as np
from numpy.typing import NDArray
from scipy.fft import next_fast_len, rfft
from scipy.signal.windows import blackmanharris
from scipy.stats import f as fisher_f

from modal_core.mode import Mode, ModeSet
from modal_core.samples import Samples
from oma_identifier.spectra.sinusoids import fit_sinusoids, Sinusoids

CHANCE = 0.01
"""Probability that noise is taken for response, over both flanks and all channels."""
MOST_CHANNELS, MOST_LINES = 12, 32
SEARCHES = 4
UNTOUCHED = 0.8
"""Share of a mode's power that lines leave in every channel where they explain nothing of it."""
REACH = 4
"""Spectral lines on both sides of a sinusoid that say nothing of what is beside it."""
UNKNOWN_WIDTH = 6.0
"""Half-width in spectral lines taken for a mode of unknown damping."""
NARROW = 8.0
"""Half-width of a mode in spectral lines below which it could pass for a line itself."""
FLANK, LEAST_FLANK = 4.0, 60.0
"""Length of a flank in half-widths of the mode, at least in spectral lines."""
MEDIAN = math.log(2.0)
"""Median over mean of a periodogram; its variance is 2.08 times that of the mean."""
BACKGROUND = 64
FALL = 1e-2
"""Of a narrow peak within ``FAR_SIDE`` spectral lines to both sides, with a taper."""
FAR_SIDE = 6
STANDS_OUT = 50.0
"""Peak over the median around it: of 10⁶ powers of noise one is above 20."""
ROUNDING = 1e-26
"""Share of the samples' power below which there is nothing but rounding."""

Real = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class LineEvidence:
    """Power spectra of the lines of a stretch, and of what is left without them.

    Parameters
    ----------
    spacing_hz : float [Hz]
        Of the spectral lines, from 0.
    leaked, left : (n_lines, n_channels) array
        Power that the sinusoids leak, and that which is left without them, of channels scaled to
        unit mean square.
    free : (n_lines,) bool array
        Where no sinusoid was near.
    n_averages : int
        Windows behind the powers; half of each overlaps with the next.
    """

    spacing_hz: float
    leaked: NDArray[np.float32]
    left: NDArray[np.float32]
    free: NDArray[np.bool_]
    n_averages: int = 1

    @classmethod
    def of(
        cls, samples: Samples, lines_hz: Sequence[float], modes: ModeSet
    ) -> 'LineEvidence | None':
        """Return the evidence of a stretch; None when there are no lines in it.

        Parameters
        ----------
        samples : Samples
            The stretch.
        lines_hz : sequence of float [Hz]
            Known lines, to less than one over the duration; others are looked for.
        modes : ModeSet
            Supposed modes: what is as narrow as they are is no line at their places.
        """
        rows = _scaled(samples)
        spacing_hz = samples.sample_rate_hz / len(rows)
        known = np.array(sorted(lines_hz), dtype=np.float64) / spacing_hz
        kept = _kept(modes, spacing_hz)
        lines, left = _sinusoids(rows, known, kept)
        if not len(lines.turn):
            return None
        rest = _power(left)
        leaked, free = np.zeros_like(rest), np.ones(len(rest), dtype=bool)
        place = np.arange(len(rest))
        for turn, phasor in zip(lines.turn, lines.phasor, strict=True):
            apart = np.abs(place - turn * len(rows) / (2.0 * np.pi))
            free &= apart > REACH + 0.5
            # The envelope: how many periods of a line the stretch holds must not matter.
            envelope = 0.25 * len(rows) / np.maximum(np.pi * apart, 1.0) ** 2
            leaked += np.outer(envelope, np.abs(phasor) ** 2).astype(np.float32)
        return cls(spacing_hz, leaked, rest, free)

    def joined(self, other: 'LineEvidence | None') -> 'LineEvidence':
        """Return the evidence of two windows together, of the first where they differ."""
        if other is None or other.left.shape != self.left.shape:
            return self
        total = self.n_averages + other.n_averages
        share = np.float32(other.n_averages / total)
        return replace(
            self,
            leaked=self.leaked + share * (other.leaked - self.leaked),
            left=self.left + share * (other.left - self.left),
            free=self.free & other.free,
            n_averages=total,
        )

    def explains(self, mode: Mode, *, anywhere: bool = False) -> bool:
        """Tell whether lines explain what there is at a supposed mode.

        Parameters
        ----------
        mode : Mode
            Supposed.
        anywhere : bool
            Test it as well where lines take next to nothing out of its band: for methods that
            make modes of peaks of noise.
        """
        at, width = mode.frequency_hz / self.spacing_hz, _half_width(mode, self.spacing_hz)
        inside = self._lines(at - width, at + width)
        if len(inside) == 0:
            return False
        left, leaked = (each[inside].mean(axis=0) for each in (self.left, self.leaked))
        if not anywhere and (left > UNTOUCHED * (left + leaked)).all():
            return False
        flank = max(FLANK * width, LEAST_FLANK)
        begin = max(2.0 * width, width + 2.0)
        sides = (
            self._lines(at - begin - flank, at - begin),
            self._lines(at + begin, at + begin + flank),
        )
        chances = [
            self._chances(left, len(inside), side)
            for side in sides
            if len(side) >= 0.25 * LEAST_FLANK
        ]
        if not chances:
            return False
        # What is no more than rounding is no response, whatever it does.
        chance = np.where(left > ROUNDING * len(self.left), np.min(chances, axis=0), 1.0)
        return bool(chance.min() * len(chance) * len(chances) > CHANCE)

    def _chances(self, power: Real, n_inside: int, side: NDArray[np.intp]) -> Real:
        """Return for each channel the probability of so much power above a flank."""
        n_independent = 0.5 * (self.n_averages + 1)
        floor = np.median(self.left[side], axis=0) / MEDIAN
        floor = np.maximum(floor, np.finfo(np.float32).tiny)
        degrees = 2.0 * n_inside * n_independent, 2.0 * len(side) * n_independent / 2.08
        return np.asarray(fisher_f.sf(power / floor, *degrees))

    def _lines(self, first: float, last: float) -> NDArray[np.intp]:
        """Return the free spectral lines from one place to another."""
        low, high = max(1, round(first)), max(1, min(round(last) + 1, len(self.free)))
        return low + np.flatnonzero(self.free[low:high])


def _half_width(mode: Mode, spacing_hz: float) -> float:
    width = mode.damping_ratio * mode.frequency_hz / spacing_hz
    return width if math.isfinite(width) else UNKNOWN_WIDTH


def _kept(modes: ModeSet, spacing_hz: float) -> list[tuple[float, float]]:
    """Return the places in spectral lines where narrow modes are supposed."""
    places = [(mode.frequency_hz / spacing_hz, _half_width(mode, spacing_hz)) for mode in modes]
    return [(at - width, at + width) for at, width in places if width < NARROW]


def _scaled(samples: Samples) -> Real:
    """Return at most a dozen channels without offset, of unit mean square, of a length to like."""
    data = samples.acceleration
    length = next_fast_len(len(data) - len(data) // 100, real=True)
    data = data[: length if length <= len(data) else len(data)]
    if data.shape[1] > MOST_CHANNELS:
        chosen = np.linspace(0, data.shape[1] - 1, MOST_CHANNELS).round().astype(int)
        data = data[:, chosen]
    rows = data - data.mean(axis=0)
    size = np.sqrt(np.mean(rows**2, axis=0))
    return np.asarray(rows[:, size > 0.0] / size[size > 0.0])


def _power(rows: Real) -> NDArray[np.float32]:
    spectrum = rfft(rows, axis=0)
    return np.asarray((spectrum.real**2 + spectrum.imag**2) / len(rows), dtype=np.float32)


def _sinusoids(rows: Real, known: Real, kept: list[tuple[float, float]]) -> tuple[Sinusoids, Real]:
    """Return the sinusoids in rows, near the known places and elsewhere, and rows less them.

    What a taper shows to be narrow is looked for in what is left, again and again: strong lines
    hide weak ones.
    """
    to_turn = 2.0 * np.pi / len(rows)
    places, left = known, rows
    fitted = Sinusoids(np.empty(0), np.empty((0, rows.shape[1]), dtype=complex))
    for search in range(SEARCHES):
        if search or not len(places):
            more = _narrow_peaks(left, places, kept)[: MOST_LINES - len(places)]
            if not len(more):
                break
            places = np.concatenate([places, more])
        fitted = fit_sinusoids(rows, places * to_turn)
        places, left = fitted.turn / to_turn, fitted.taken_from(rows)
    return fitted, left


def _narrow_peaks(rows: Real, known: Real, kept: list[tuple[float, float]]) -> Real:
    """Return the places of narrow peaks in spectral lines, the strongest first."""
    taper = blackmanharris(len(rows), sym=False)[:, None]
    power = _power(taper * rows)
    n_whole = len(power) // BACKGROUND * BACKGROUND
    if n_whole < 2 * BACKGROUND:
        return np.empty(0)
    blocks = power[:n_whole].reshape(-1, BACKGROUND, power.shape[1])
    level = np.median(blocks, axis=1)
    level = np.minimum(level, np.minimum(np.roll(level, 1, axis=0), np.roll(level, -1, axis=0)))
    beyond = np.minimum(np.arange(len(power)) // BACKGROUND, len(level) - 1)
    ratio = power / np.maximum(level, np.finfo(np.float32).tiny)[beyond]
    best = ratio.max(axis=1)
    inner = slice(FAR_SIDE, len(power) - FAR_SIDE)
    sides = np.maximum(best[: -2 * FAR_SIDE], best[2 * FAR_SIDE :])
    peaks = best[inner] >= best[FAR_SIDE - 1 : -FAR_SIDE - 1]
    peaks &= best[inner] > best[FAR_SIDE + 1 : len(best) - FAR_SIDE + 1]
    peaks &= (best[inner] > STANDS_OUT) & (sides < FALL * best[inner])
    found = FAR_SIDE + np.flatnonzero(peaks)
    found = found[np.argsort(-best[found])]
    new = [place for place in found if not _is_taken(float(place), known, kept)]
    return np.array(new, dtype=np.float64)


def _is_taken(place: float, known: Real, kept: list[tuple[float, float]]) -> bool:
    near = bool(np.any(np.abs(known - place) < 1.0))
    return near or any(low - 2.0 <= place <= high + 2.0 for low, high in kept)
