"""How one sensor is seen from others at one peak: phase, beat, and what chance does to them.

References
----------
Knapp and Carter (1976), doi:10.1109/TASSP.1976.1162830 (delay from phases, weighted by coherence);
Bendat and Piersol (2010), Random Data, 4th ed., table 9.6 (variance of a phase).
"""

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from oma_identifier.synchrony.sensor_peaks import Peak

LATEST_S = 0.5
"""Largest delay that is looked for."""
COHERENT = 0.3
"""Least squared coherence of a peak; noise of 11 values comes there in one of thirty-five."""
FEWEST_FREE = 6.0
BEAT_LINES = 12
"""Lines of a peak from where on its beat is its own and not that of the taper."""

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class PeakView:
    """How one sensor is seen from others at one peak.

    Parameters
    ----------
    frequency_hz : float [Hz]
        Of the peak.
    lag_s : (n_lags,) array [s]
        Delays to put right.
    square : (n_lags,) complex array
        Sum of the squared cross powers of all pairs of channels: it has twice their phase,
        whatever the signs of the shape's entries.
    phase_std : float [rad]
        What chance does to the phase.
    complexity : float
        What a shape's imaginary parts do to it, in multiples of those.
    beat_s : float [s]
        Delay of the beat of this band.
    width_hz : float [Hz]
        Of the band, root mean square; 0 where it has no beat of its own.
    """

    frequency_hz: float
    lag_s: Real
    square: Complex
    phase_std: float
    complexity: float
    beat_s: float
    width_hz: float


def view_at(peak: Peak, own: Complex, beside: Complex, complexity: float) -> PeakView | None:
    """Return how a sensor is seen at a peak; None where it is not.

    Parameters
    ----------
    peak : Peak
        Where.
    own, beside : (n_tapers, n_lines, n) complex array
        Spectra of the sensor's channels and of others, which are in step.
    complexity : float
        See :class:`PeakView`.
    """
    spread_hz = max(float(np.ptp(peak.line_hz)), 1e-9)
    n_lags = math.ceil(LATEST_S * spread_hz / 0.2)
    lag_s = LATEST_S * (np.arange(-n_lags, n_lags + 1) / n_lags)
    turn = np.exp(2j * np.pi * np.outer(lag_s, peak.line_hz))
    cross = np.einsum('tla,tlb->lab', own, beside.conj()).reshape(len(peak.line_hz), -1)
    cross = turn @ cross
    own_power, other_power = np.abs(own) ** 2, np.abs(beside) ** 2
    coherence = np.sum(np.abs(cross) ** 2, axis=1) / (own_power.sum() * other_power.sum() + 1e-300)
    best = int(np.argmax(coherence))
    if peak.n_free < FEWEST_FREE or coherence[best] < COHERENT:
        return None
    clear = min(float(coherence[best]), 0.9999)
    phase_std = math.sqrt((1.0 - clear) / (2.0 * clear * peak.n_free))
    weight = np.sqrt(own_power.sum(axis=(0, 2)) * other_power.sum(axis=(0, 2)))
    width_hz = _width(peak, weight) if len(peak.line_hz) >= BEAT_LINES else 0.0
    square = np.sum(cross**2, axis=1)
    beat_s = _top(lag_s, coherence, best)
    return PeakView(peak.frequency_hz, lag_s, square, phase_std, complexity, beat_s, width_hz)


def _top(lag_s: Real, coherence: Real, best: int) -> float:
    """Return where a parabola through three values has its top."""
    if not 0 < best < len(lag_s) - 1:
        return float(lag_s[best])
    below, top, above = coherence[best - 1 : best + 2]
    bend = 2.0 * top - below - above
    step = 0.5 * (above - below) / bend if bend > 0.0 else 0.0
    return float(lag_s[best] + step * (lag_s[1] - lag_s[0]))


def _width(peak: Peak, weight: Real) -> float:
    middle = np.average(peak.line_hz, weights=weight)
    return math.sqrt(float(np.average((peak.line_hz - middle) ** 2, weights=weight)))
