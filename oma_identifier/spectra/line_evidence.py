"""Whether there is response at a mode that lines do not explain.

Between lines a covariance of finite length holds their leakage and their products, and a subspace
method finds well determined poles to describe it.  So every line is fitted to the samples and
taken out, and a taper keeps what their modulation leaves behind at its place.  A mode must show
two things in what is left:

* It stands above the floor between both flanks; noise without any mode passes with
  ``response_chance``.  Medians are compared, so that a few narrow peaks are neither response nor
  floor.  Where lines and leakage are not nearly all there is at a mode they do not explain it:
  this is not tested, unless the method makes modes of peaks of noise.
* It has skirts.  The response to random forces falls by the mode's own bell.  What else there is
  adds to it, but for a neighbour that the same force shakes: that takes away from one flank, and
  not in all channels.  A line with its modulation ends: power far below the bell of the estimated
  mode on both flanks and in all channels says that there is none.

References
----------
Thomson (1982), doi:10.1109/PROC.1982.12433, Section XIII (lines first, then the rest).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
import math

import numpy as np
from numpy.typing import NDArray
from scipy.fft import next_fast_len

from modal_core.mode import Mode, ModeSet
from modal_core.numbers.chance import fisher_share, fisher_tail
from modal_core.samples import Samples
from oma_identifier.spectra.line_search import (
    MOST_LINES,
    narrow_peaks,
    peaks_over_their_bell,
    power,
    power_cut_out,
    sinusoids_of,
)
from oma_identifier.spectra.thresholds import SPECTRA

MOST_CHANNELS = 12
LINES_BESIDE = 4
"""Spectral lines on both sides of a sinusoid that say nothing of what is beside it."""
UNKNOWN_WIDTH, WIDEST_UNKNOWN = 6.0, 0.15
"""Half-widths tried for a mode of unknown damping: from so many spectral lines to this share of
its frequency, which is the largest damping ratio of a mode."""
FLANK, LEAST_FLANK = 4.0, 60.0
"""Length of a flank in half-widths of the mode, at least in spectral lines."""
SKIRT, LEAST_SKIRT = 4.0, 10.0
"""The same for the part of it where the bell is looked for."""
LOBE = 4.0
"""Half-width of the taper's main lobe in spectral lines: nothing nearer is beside a peak."""
BLUR = 1.5
"""Its half-power half-width, roughly."""
HIDDEN = 2.0 * LOBE
"""Half-width in spectral lines in which skirts are looked for where a line hides a mode."""
SHARED = 2.0
"""Spectral lines behind one independent value, of the taper."""
MEDIAN, MEDIAN_VARIANCE = math.log(2.0), 2.08
"""Median over mean of a periodogram; its variance over that of the mean."""
ROUNDING_OF_SAMPLES = 1e-26
"""Share of the samples' power below which there is nothing but rounding."""

Real = NDArray[np.float64]
Places = NDArray[np.intp]


@dataclass(frozen=True, slots=True)
class LineEvidence:
    """Power spectra of a stretch, and of what is left of it without lines and leakage.

    Parameters
    ----------
    spacing_hz : float [Hz]
        Of the spectral lines, from 0.
    seen, left : (n_lines, n_channels) array
        Power in the stretch cut out as it is, which a covariance sees as well; and that which is
        left without sinusoids, tapered.  Of channels scaled to unit mean square.
    free : (n_lines,) bool array
        Where no sinusoid was near.
    n_averages : int
        Windows behind the powers; half of each overlaps with the next.
    """

    spacing_hz: float
    seen: NDArray[np.float32]
    left: NDArray[np.float32]
    free: NDArray[np.bool_]
    n_averages: int = 1

    @classmethod
    def of(cls, samples: Samples, lines_hz: Sequence[float], modes: ModeSet) -> 'LineEvidence':
        """Return the evidence of a stretch.

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
        lines, left = sinusoids_of(rows, known, _kept(modes, spacing_hz))
        seen = power_cut_out(rows)
        free = np.ones(len(seen), dtype=bool)
        for place in lines.turn * len(rows) / (2.0 * np.pi):
            free &= np.abs(np.arange(len(free)) - place) > LINES_BESIDE + 0.5
        return cls(spacing_hz, seen, left, free)

    def joined(self, other: 'LineEvidence | None') -> 'LineEvidence':
        """Return the evidence of two windows together, of the first where they differ."""
        if other is None or other.left.shape != self.left.shape:
            return self
        total = self.n_averages + other.n_averages
        share = np.float32(other.n_averages / total)
        return replace(
            self,
            seen=self.seen + share * (other.seen - self.seen),
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
            It must stand above the floor even where lines are next to nothing of its band: for
            methods that make modes of peaks of noise.
        """
        at, width = mode.frequency_hz / self.spacing_hz, _half_width(mode, self.spacing_hz)
        if math.isnan(mode.damping_ratio):
            return anywhere and not self._stands_out_at_some_width(at)
        around = _span(at - SPECTRA.sidebands, at + SPECTRA.sidebands, self.free)
        if width < SPECTRA.resolved and not self.free[around].all():
            return True
        inside = self._lines(at - max(width, BLUR), at + max(width, BLUR))
        if len(inside) == 0:
            # A line hides the top of the bell: the skirts must show.
            return not self._stands_out(at, HIDDEN, self._lines(at - HIDDEN, at + HIDDEN))
        tested = anywhere or self._is_touched(at, width)
        if tested and not self._stands_out(at, width, inside):
            return True
        return self._ends(at, width, inside)

    def _stands_out_at_some_width(self, at: float) -> bool:
        """Tell whether there is more at a peak of unknown width than beside it."""
        width = UNKNOWN_WIDTH
        while width < WIDEST_UNKNOWN * at:
            if self._stands_out(at, width, self._lines(at - width, at + width)):
                return True
            width *= 2.0
        return False

    def _is_touched(self, at: float, width: float) -> bool:
        near = self._lines(at - max(width, LEAST_SKIRT), at + max(width, LEAST_SKIRT))
        left, seen = (each[near].mean(axis=0) for each in (self.left, self.seen))
        return bool((left < SPECTRA.untouched * seen).any())

    def _stands_out(self, at: float, width: float, inside: Places) -> bool:
        """Tell whether there is more at a place than on both its flanks, in any channel."""
        sides = self._sides(at, width, max(FLANK * width, LEAST_FLANK))
        if not sides or len(inside) == 0:
            return True
        level = np.median(self.left[inside], axis=0) / MEDIAN
        floors = np.array([np.median(self.left[side], axis=0) / MEDIAN for side in sides])
        # Between flanks leakage falls by a power of the distance.
        floor = np.exp(np.log(np.maximum(floors, np.finfo(np.float32).tiny)).mean(axis=0))
        degrees = [
            2.0 * self._n_independent(n_lines) / MEDIAN_VARIANCE
            for n_lines in (len(inside), sum(len(side) for side in sides))
        ]
        # What is no more than rounding is no response, whatever it does.
        is_more = level > ROUNDING_OF_SAMPLES * len(self.left)
        chance = np.where(is_more, fisher_tail(level / floor, *degrees), 1.0)
        return bool(chance.min() * len(chance) <= SPECTRA.response_chance)

    def _ends(self, at: float, width: float, inside: Places) -> bool:
        """Tell whether there is less on the flanks than the bell of a mode would leave there.

        A mode that one force shakes together with its neighbour has an antiresonance on one side,
        in the channels where their shapes have one sign: a line ends on both sides, in all.
        """
        sides = self._sides(at, width, max(SKIRT * width, LEAST_SKIRT))
        power = self.left[inside].mean(axis=0)
        shown = power > SPECTRA.shown * power.max(initial=0.0)
        # A narrow neighbour in a wide bell is not its top.
        top = np.median(self._over_bell(at, width, inside)[:, shown], axis=0) / MEDIAN
        n_top, chances = self._n_independent(len(inside)) / MEDIAN_VARIANCE, []
        for side in sides:
            skirt = np.median(self._over_bell(at, width, side)[:, shown], axis=0) / MEDIAN
            n_skirt = self._n_independent(len(side)) / MEDIAN_VARIANCE
            shares = fisher_share(SPECTRA.bell_excess * skirt / top, 2.0 * n_skirt, 2.0 * n_top)
            chances.append(float(np.max(shares)))
        return len(chances) > 0 and max(chances) < SPECTRA.no_skirts_chance

    def _over_bell(self, at: float, width: float, lines: Places) -> Real:
        """Return power over the bell of a mode, of displacement or acceleration: the lower one."""
        bell = 1.0 / ((lines - at) ** 2 + math.hypot(width, BLUR) ** 2)
        bell *= (2.0 * at / (lines + at)) ** 2 * np.minimum(1.0, (lines / at) ** 4)
        return np.asarray(self.left[lines] / bell[:, None], dtype=np.float64)

    def _n_independent(self, n_lines: int) -> float:
        return max(1.0, n_lines / SHARED) * 0.5 * (self.n_averages + 1)

    def _sides(self, at: float, width: float, length: float) -> list[Places]:
        """Return the free spectral lines of both flanks, where there are enough."""
        begin = max(2.0 * width, width + LOBE + BLUR)
        highest = 2.0 * SPECTRA.flank_share * (len(self.left) - 1)
        sides = (
            self._lines(at - begin - length, at - begin),
            self._lines(at + begin, min(at + begin + length, highest)),
        )
        return [side for side in sides if len(side) >= SPECTRA.least_flank * length]

    def _lines(self, first: float, last: float) -> Places:
        """Return the free spectral lines from one place to another."""
        span = _span(first, last, self.free)
        return np.asarray(span.start + np.flatnonzero(self.free[span]), dtype=np.intp)


def _span(first: float, last: float, lines: NDArray[np.bool_]) -> slice:
    return slice(max(1, round(first)), max(1, min(round(last) + 1, len(lines))))


def _half_width(mode: Mode, spacing_hz: float) -> float:
    width = mode.damping_ratio * mode.frequency_hz / spacing_hz
    return width if math.isfinite(width) else UNKNOWN_WIDTH


def _kept(modes: ModeSet, spacing_hz: float) -> list[tuple[float, float]]:
    """Return the places in spectral lines where narrow modes are supposed."""
    places = [(mode.frequency_hz / spacing_hz, _half_width(mode, spacing_hz)) for mode in modes]
    return [(at - width, at + width) for at, width in places if width < SPECTRA.narrow]


def narrow_peaks_hz(samples: Samples) -> list[float]:
    """Return where the spectrum of a stretch peaks as narrowly as that of a line."""
    rows = _scaled(samples)
    places = narrow_peaks(power(rows))[:MOST_LINES]
    return [float(place) * samples.sample_rate_hz / len(rows) for place in places]


def peaks_hz(samples: Samples) -> list[float]:
    """Return where lines may be: narrow peaks, and peaks over the bell that they are in."""
    rows = _scaled(samples)
    each = power(rows)
    places = np.concatenate([narrow_peaks(each), peaks_over_their_bell(each)])
    _, first = np.unique(places, return_index=True)
    places = places[np.sort(first)][:MOST_LINES]
    return [float(place) * samples.sample_rate_hz / len(rows) for place in places]


def _scaled(samples: Samples) -> Real:
    """Return at most a dozen channels without offset, of unit mean square, of a length to like."""
    n_rows, n_channels = samples.acceleration.shape
    length = next_fast_len(n_rows - n_rows // 100, real=True)
    chosen: slice | NDArray[np.intp] = slice(None)
    if n_channels > MOST_CHANNELS:
        chosen = np.linspace(0, n_channels - 1, MOST_CHANNELS).round().astype(int)
    rows = samples.widened(slice(length if length <= n_rows else n_rows), chosen)
    rows = rows - rows.mean(axis=0)
    size = np.sqrt(np.mean(rows**2, axis=0))
    rows = rows[:, size > 0.0]
    rows /= size[size > 0.0]
    return np.asarray(rows)
