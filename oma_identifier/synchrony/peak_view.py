"""How sensors are seen from others at one peak: phase, beat, and what chance does to them.

References
----------
Knapp and Carter (1976), doi:10.1109/TASSP.1976.1162830 (delay from phases, weighted by coherence);
Bendat and Piersol (2010), Random Data, 4th ed., table 9.6 (variance of a phase).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
import math

import numpy as np
from numpy.typing import NDArray

from oma_identifier.synchrony.sensor_peaks import Peak
from oma_identifier.synchrony.thresholds import SYNCHRONY

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class PeakView:
    """How sensors are seen from others at one peak.

    Parameters
    ----------
    frequency_hz : float [Hz]
        Of the peak.
    lag_s : (n_lags,) array [s]
        Delays to put right, equidistant.
    square : (n_sensors, n_lags) complex array
        Sum of the squared cross powers of all pairs of channels: it has twice their phase,
        whatever the signs of the shape's entries.
    phase_std : (n_sensors,) array [rad]
        What chance does to the phase; not a number where a sensor is not seen.
    complexity : (n_sensors,) array
        What a shape's imaginary parts do to it, in multiples of those.
    beat_s : (n_sensors,) array [s]
        Delay of the beat of this band.
    width_hz : (n_sensors,) array [Hz]
        Of the band, root mean square; 0 where it has no beat of its own.
    """

    frequency_hz: float
    lag_s: Real
    square: Complex
    phase_std: Real
    complexity: Real
    beat_s: Real
    width_hz: Real

    @property
    def is_seen(self) -> NDArray[np.bool_]:
        """Which sensors are, (n_sensors,)."""
        return np.isfinite(self.phase_std)

    def of(self, sensors: NDArray[np.int64]) -> 'PeakView':
        """Return the same of some sensors only."""
        return replace(
            self,
            square=self.square[sensors],
            phase_std=self.phase_std[sensors],
            complexity=self.complexity[sensors],
            beat_s=self.beat_s[sensors],
            width_hz=self.width_hz[sensors],
        )


def view_at(
    peak: Peak,
    spectra: Complex,
    own: Sequence[NDArray[np.int64]],
    beside: NDArray[np.int64],
    shown: Real,
    shown_beside: float,
) -> PeakView:
    """Return how sensors are seen at a peak.

    Parameters
    ----------
    peak : Peak
        Where.
    spectra : (n_tapers, n_lines, n_channels) complex array
        Of the peak; those of ``beside`` in step.
    own : sequence of int array
        Channels of each of the sensors.
    beside : int array
        Channels of others, which are in step.
    shown : (n_sensors,) array
        Power of the peak in each sensor, a share of its variance.
    shown_beside : float
        The same in the others, their mean.
    """
    # A sensor that hardly shows a mode shows flanks of others there.  Under a common force these
    # are in step with the peak, at any phase, which turns from one side of the peak to the other
    # as if the beat were late.
    alike = np.minimum(shown, shown_beside) / np.maximum(shown, shown_beside)
    spread_hz = max(float(np.ptp(peak.line_hz)), 1e-9)
    n_lags = math.ceil(SYNCHRONY.latest_s * spread_hz / 0.2)
    lag_s = SYNCHRONY.latest_s * (np.arange(-n_lags, n_lags + 1) / n_lags)
    turn = np.exp(2j * np.pi * np.outer(lag_s, peak.line_hz))
    power = np.sum(np.abs(spectra) ** 2, axis=0)
    others = power[:, beside].sum(axis=1)
    each = np.array([power[:, columns].sum(axis=1) for columns in own])
    crosses = [turn @ _cross(spectra, columns, beside) for columns in own]
    total = each.sum(axis=1) * others.sum() + 1e-300
    coherence = np.array([np.sum(np.abs(cross) ** 2, axis=1) for cross in crosses])
    coherence /= total[:, None]
    best = np.argmax(coherence, axis=1)
    top = coherence.max(axis=1)
    clear = np.minimum(top, 0.9999)
    with np.errstate(divide='ignore'):
        phase_std = np.sqrt((1.0 - clear) / (2.0 * clear * peak.n_free))
    is_seen = (top >= SYNCHRONY.coherent) & (peak.n_free >= SYNCHRONY.fewest_free)
    is_seen &= alike > SYNCHRONY.phase_alike
    has_beat = (alike > SYNCHRONY.beat_alike) & (len(peak.line_hz) >= SYNCHRONY.beat_lines)
    return PeakView(
        peak.frequency_hz,
        lag_s,
        np.array([np.sum(cross**2, axis=1) for cross in crosses]),
        np.where(is_seen, phase_std, np.nan),
        # An imaginary part turns a small entry of a shape more than a large one.
        np.sqrt(0.5 / shown + 0.5 / shown_beside),
        _tops(lag_s, coherence, best),
        np.where(has_beat, _widths(peak, np.sqrt(each * others)), 0.0),
    )


def _cross(spectra: Complex, own: NDArray[np.int64], beside: NDArray[np.int64]) -> Complex:
    """Return the products of two sensors' channels, (n_lines, n_pairs)."""
    first = spectra[:, :, own].transpose(1, 2, 0)
    second = spectra[:, :, beside].conj().transpose(1, 0, 2)
    return np.asarray((first @ second).reshape(spectra.shape[1], -1))


def _tops(lag_s: Real, coherence: Real, best: NDArray[np.int64]) -> Real:
    """Return where parabolas through three values have their tops."""
    inside = np.clip(best, 1, len(lag_s) - 2)
    rows = np.arange(len(best))
    below, top, above = (coherence[rows, inside + k] for k in (-1, 0, 1))
    bend = 2.0 * top - below - above
    is_top = (inside == best) & (bend > 0.0)
    step = 0.5 * (above - below) / np.where(is_top, bend, np.inf)
    return np.asarray(lag_s[best] + step * (lag_s[1] - lag_s[0]))


def _widths(peak: Peak, weight: Real) -> Real:
    """Return the width of the band of each sensor; weights (n_sensors, n_lines)."""
    share = weight / np.maximum(weight.sum(axis=1, keepdims=True), 1e-300)
    middle = share @ peak.line_hz
    return np.asarray(np.sqrt(np.sum(share * (peak.line_hz - middle[:, None]) ** 2, axis=1)))
