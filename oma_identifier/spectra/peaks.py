"""Whether the spectrum peaks where a pole lies: resonances do, edges of an excited band do not.

Where a spectrum falls from one level to another, as at the end of an excited band or of an
anti-aliasing filter, a subspace method needs poles to describe it, and the data determine them
well.  A resonance differs by falling to both sides.  The combination of channels that shows the
peak best is chosen from every other frequency and the test is made on those in between, which are
independent: the ratio of two mean powers then follows Fisher's F exactly, whatever was chosen.
A mode beyond a filter makes a peak with it, of its flank and the filter's: above such a peak the
spectrum falls faster than above any resonance.

That takes the lines for independent, which they are under a steady force.  A vehicle that
crosses a bridge is loud for a moment, and its axles and its bounce have peaks of their own.  A
mode answers to all forces: its peak stays when every moment counts the same.
"""

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.fft import fft, ifft, next_fast_len, rfft
from scipy.linalg import eigh
from scipy.ndimage import uniform_filter1d

from modal_core.numbers.chance import fisher_tail
from modal_core.samples import Samples
from oma_identifier.spectra.band_edges import band_edges
from oma_identifier.spectra.thresholds import SPECTRA

FLANK = (2.0, 4.0)
"""Reach of a flank in half-power half-widths; there a resonance has lost 5 to 12 dB and more."""
BELL = (1.0 + 0.5**2) / (1.0 + np.mean(FLANK) ** 2)
"""Median power of a resonance on a flank over that within its half-power band."""
MOST_CHANNELS, CHANNELS_THAT_END = 12, 4
REACH, MOMENT = 5.0, 5
"""Half-widths to either side in which the level is told, and values of the band's course, one per
2 · ``REACH`` · half-width, over which it is a mean: a moment is as long as half a half-width tells
apart."""
PER_LINE_EVENED = 1.0
"""Degrees of freedom of a line of what was evened: its neighbours know half of it."""
TINY = 1e-30


class SpectralPeaks:
    """Tests for peaks in the spectra of one stretch.

    Parameters
    ----------
    samples : Samples
        The stretch; transformed when the first test is asked for.
    """

    def __init__(self, samples: Samples) -> None:
        self._samples = samples

    @cached_property
    def _lines(self) -> NDArray[np.complex64]:
        """Return the discrete Fourier transform, (n_lines, n_channels), of the liveliest."""
        return self._transformed(MOST_CHANNELS)

    def _transformed(self, most_channels: int) -> NDArray[np.complex64]:
        n_rows, n_channels = self._samples.acceleration.shape
        length = next_fast_len(n_rows - n_rows // 100, real=True)
        chosen: slice | NDArray[np.intp] = slice(None)
        if n_channels > most_channels:
            chosen = np.linspace(0, n_channels - 1, most_channels).round().astype(int)
        data = self._samples.widened(slice(length if length <= n_rows else n_rows), chosen)
        rows = np.ascontiguousarray(data.T)
        rows = rows - rows.mean(axis=1, keepdims=True)
        size = rows.std(axis=1)
        rows = (rows[size > 0.0] / size[size > 0.0, None]).astype(np.float32)
        return np.ascontiguousarray(rfft(rows, axis=1).T)

    def chance(self, frequency_hz: float, half_width_hz: float) -> float | None:
        """Return the probability that a spectrum without a peak looks like the one here.

        Parameters
        ----------
        frequency_hz, half_width_hz : float [Hz]
            Natural frequency and half-power half-width of the supposed resonance.

        Returns
        -------
        float or None
            None where the peak is too narrow for the record to tell.
        """
        at, width = self._place(frequency_hz, half_width_hz)
        if round(2.0 * width) < SPECTRA.fewest_peak_lines:
            return None
        return self._chance(*self._parts(at, width))

    def is_edge(self, frequency_hz: float, half_width_hz: float) -> bool:
        """Tell whether the spectrum falls from one level to another here, without a peak.

        Parameters
        ----------
        frequency_hz, half_width_hz : float [Hz]
            Natural frequency and half-power half-width of the supposed resonance.
        """
        at, width = self._place(frequency_hz, half_width_hz)
        if round(2.0 * width) < SPECTRA.fewest_edge_lines:
            return False
        peak, low, high = self._parts(at, width)
        if min(len(low), len(high)) < SPECTRA.fewest_edge_lines // 4:
            return False
        powers = [float(np.mean(np.abs(flank) ** 2)) for flank in (low, high)]
        steep = max(powers) > SPECTRA.edge * min(powers)
        return steep and self._chance(peak, low, high) > SPECTRA.no_peak

    def is_of_moments(self, frequency_hz: float, half_width_hz: float) -> bool:
        """Tell whether a peak is that of few loud moments, and the others have none.

        Parameters
        ----------
        frequency_hz, half_width_hz : float [Hz]
            Natural frequency and half-power half-width of the supposed resonance.
        """
        at, width = self._place(frequency_hz, half_width_hz)
        around = _rows(at - REACH * width, at + REACH * width, len(self._lines))
        course = ifft(self._lines[around], axis=0)
        if len(course) == 0 or not _steadiness(course) < SPECTRA.unsteady:
            return False
        if not self._chance(*self._parts(at, width)) < SPECTRA.sure_peak_chance:
            return False
        # The channels that show a peak best at all times are chosen first: what moved those that
        # are silent otherwise would be lost among the others.
        parts = _parts(_evened(course), at - around.start, width)
        chosen = _evened((course @ _combination(*parts))[:, None])
        on, *flanks = (_squares(part) for part in _parts(chosen, at - around.start, width))
        return _chance_of(on, flanks, PER_LINE_EVENED) > SPECTRA.usual_peak_chance

    def is_by_end(self, frequency_hz: float, half_width_hz: float) -> bool:
        """Tell whether the response ends so near that a pole here may be the end's.

        Parameters
        ----------
        frequency_hz, half_width_hz : float [Hz]
            Natural frequency and half-power half-width of the supposed resonance.
        """
        distance = np.abs(self._ends_hz - frequency_hz)
        return bool(np.any(distance < SPECTRA.edge_reach * half_width_hz))

    def is_cut(self, frequency_hz: float, half_width_hz: float) -> bool:
        """Tell whether the spectrum falls faster above a pole than any resonance, in all channels.

        As where a filter ends it.  An antiresonance is narrow, and not one of all channels.

        Parameters
        ----------
        frequency_hz, half_width_hz : float [Hz]
            Natural frequency and half-power half-width of the supposed resonance.
        """
        at, width = self._place(frequency_hz, half_width_hz)
        if round(2.0 * width) < SPECTRA.fewest_edge_lines:
            return False
        peak, _, above = _parts(self._tapered, at - 1.0, width)
        if len(above) < SPECTRA.fewest_edge_lines // 4:
            return False
        # Of medians, for a line in the peak is no part of it.
        top, left = (np.median(_squares(part), axis=0) for part in (peak, above))
        shown = top > SPECTRA.shown * top.max()
        return bool(np.all(left[shown] < SPECTRA.cut * BELL * top[shown]))

    @cached_property
    def _tapered(self) -> NDArray[np.complex64]:
        return _tapered(self._lines)

    @cached_property
    def _ends_hz(self) -> NDArray[np.float64]:
        """Return where the response ends [Hz]: in all channels at once, so that a few tell."""
        lines = self._transformed(CHANNELS_THAT_END)
        tapered = _tapered(lines)
        power = np.einsum('lc,lc->l', tapered, tapered.conj()).real.astype(np.float64)
        spacing = self._samples.sample_rate_hz / 2.0 / (len(lines) - 1)
        return (band_edges(power) + 1.0) * spacing

    def _place(self, frequency_hz: float, half_width_hz: float) -> tuple[float, float]:
        """Return where a resonance is, and its half-width, in lines."""
        spacing = self._samples.sample_rate_hz / 2.0 / (len(self._lines) - 1)
        return frequency_hz / spacing, half_width_hz / spacing

    def _parts(self, at: float, width: float) -> tuple[NDArray[np.complex64], ...]:
        return _parts(self._lines, at, width)

    @staticmethod
    def _chance(
        peak: NDArray[np.complex64], low: NDArray[np.complex64], high: NDArray[np.complex64]
    ) -> float:
        if min(len(low), len(high)) < SPECTRA.fewest_edge_lines // 4:
            return 1.0
        weight = _combination(peak, low, high)
        on, *flanks = (_squares(part[1::2] @ weight) for part in (peak, low, high))
        return _chance_of(on, flanks)


def _tapered(lines: NDArray[np.complex64]) -> NDArray[np.complex64]:
    """Return lines under Hann's window, which keeps strong modes off weak flanks.

    They begin at the second one.
    """
    return np.asarray(lines[1:-1] - 0.5 * (lines[:-2] + lines[2:]))


def _combination(
    peak: NDArray[np.complex64], low: NDArray[np.complex64], high: NDArray[np.complex64]
) -> NDArray[np.complex64]:
    """Return what the channels are weighted by to show a peak best, of every other line."""
    beside = _power(low[::2]) + _power(high[::2])
    ridge = 1e-6 * np.trace(beside).real * np.eye(len(beside))
    return np.asarray(eigh(_power(peak[::2]), beside + ridge)[1][:, -1].conj())


def _chance_of(
    on: NDArray[np.float32], flanks: Sequence[NDArray[np.float32]], per_line: float = 2.0
) -> float:
    """Return the probability that lines as strong as those beside them look like this."""
    return max(
        float(fisher_tail(on.mean() / off.mean(), per_line * len(on), per_line * len(off)))
        for off in flanks
    )


def _level(course: NDArray[np.complex64]) -> NDArray[np.float32]:
    power = np.sum(_squares(course), axis=1)
    return np.asarray(uniform_filter1d(power, MOMENT, mode='nearest'))


def _steadiness(course: NDArray[np.complex64]) -> float:
    level = _level(course)
    return float(np.mean(level) ** 2 / np.mean(level**2))


def _evened(course: NDArray[np.complex64]) -> NDArray[np.complex64]:
    """Return the lines of a band's course were it as strong at every moment."""
    level = np.maximum(_level(course), TINY)
    return np.asarray(fft(course / np.sqrt(level)[:, None], axis=0))


def _squares(values: NDArray[np.complex64]) -> NDArray[np.float32]:
    return np.asarray(np.abs(values) ** 2)


def _parts(
    lines: NDArray[np.complex64], at: float, width: float
) -> tuple[NDArray[np.complex64], ...]:
    """Return the lines of the peak and of the flanks below and above."""
    near, far = FLANK
    return tuple(
        lines[_rows(at + first * width, at + last * width, len(lines))]
        for first, last in ((-1.0, 1.0), (-far, -near), (near, far))
    )


def _rows(first: float, last: float, n_lines: int) -> slice:
    return slice(max(1, round(first)), max(1, min(round(last) + 1, n_lines)))


def _power(lines: NDArray[np.complex64]) -> NDArray[np.complex64]:
    return np.asarray(lines.T @ lines.conj() / max(len(lines), 1))
