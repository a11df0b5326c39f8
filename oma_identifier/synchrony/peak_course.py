"""How the channels go through a window at one peak: its narrow band, demodulated.

Three sine tapers of one window are three weighted looks at the same course; together they weigh it
nearly evenly but for the ends.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_core.samples import Samples
from oma_identifier.synchrony.sensor_peaks import Peak, TAPERS, transform_length

LEAST_WEIGHT = 0.2
"""Sum of the squared tapers below which a moment is left out: 4 % of a window at either end."""

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class Course:
    """Complex amplitudes at one peak, row after row independent but for the peak itself.

    Parameters
    ----------
    frequency_hz, width_hz : float [Hz]
        Middle and width of the band.
    time_ns : (n_rows,) int64 array [ns]
        Rising.
    values : (n_rows, n_channels) complex array
        In one unit over all windows; noise of a channel has one variance in all rows.
    """

    frequency_hz: float
    width_hz: float
    time_ns: NDArray[np.int64]
    values: Complex

    @property
    def step_ns(self) -> int:
        """Time from one row to the next."""
        return int(np.median(np.diff(self.time_ns))) if len(self.time_ns) > 1 else 0

    def since(self, first_ns: int) -> 'Course':
        """Return the rows from a time on."""
        first = int(np.searchsorted(self.time_ns, first_ns))
        return replace(self, time_ns=self.time_ns[first:], values=self.values[first:])

    def of_channels(self, columns: Sequence[int]) -> 'Course':
        """Return the course of some channels."""
        return replace(self, values=self.values[:, columns])

    def after(self, earlier: Iterable['Course']) -> 'Course':
        """Return the course with what an earlier window showed of its peak before it.

        No more than as many rows again.
        """
        near = [each for each in earlier if self._is_of_same_peak(each)]
        if not near or not len(self.time_ns):
            return self
        before = min(near, key=lambda each: abs(each.frequency_hz - self.frequency_hz))
        end = int(np.searchsorted(before.time_ns, self.time_ns[0]))
        rows = slice(max(0, end - len(self.time_ns)), end)
        return replace(
            self,
            time_ns=np.concatenate([before.time_ns[rows], self.time_ns]),
            values=np.concatenate([before.values[rows], self.values]),
        )

    def _is_of_same_peak(self, other: 'Course') -> bool:
        away = abs(other.frequency_hz - self.frequency_hz)
        return away < 0.5 * min(self.width_hz, other.width_hz)


def course_of(peak: Peak, samples: Samples, scale: Real) -> Course:
    """Return the course of a peak.

    Parameters
    ----------
    peak : Peak
        Of these samples.
    samples : Samples
        One window.
    scale : (n_channels,) array [m/s²]
        Standard deviations, which the peaks are in units of.
    """
    n_lines = len(peak.line_hz)
    length = transform_length(samples)
    share = np.arange(n_lines) / n_lines
    taper = np.sin(np.pi * np.outer(np.arange(1, TAPERS + 1), share))
    weight = np.sum(taper**2, axis=0)
    kept = (weight > LEAST_WEIGHT) & (share * length < len(samples.acceleration))
    tapered = np.fft.ifft(peak.spectra, axis=1)[:, kept]
    values = np.einsum('kt,ktc->tc', taper[:, kept] / np.sqrt(weight[kept]), tapered)
    step_ns = length / samples.sample_rate_hz * NANOSECONDS_PER_SECOND
    return Course(
        frequency_hz=peak.frequency_hz,
        width_hz=float(np.ptp(peak.line_hz)),
        time_ns=samples.start_ns + np.rint(step_ns * share[kept]).astype(np.int64),
        values=values * (math.sqrt(n_lines) * scale),
    )
