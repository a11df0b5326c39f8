"""Singular values of the cross-spectral density: the background of a stabilisation diagram."""

from dataclasses import dataclass, replace
import math

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy.fft import next_fast_len, rfft

from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_core.numbers.tapers import hann
from modal_core.samples import Samples

N_VALUES = 3
LONGEST_SEGMENT_S = 60.0
FEWEST_SEGMENTS = 8
ROWS_AT_ONCE, LINES_AT_ONCE, VALUES_AT_ONCE = 512, 256, 1 << 21
REFRESHED = 1.0 / 8.0
"""Share of a window that is new when its spectrum is made again."""


@dataclass(frozen=True, slots=True)
class SingularValueSpectrum:
    """Largest singular values of the cross-spectral density.

    Parameters
    ----------
    frequency_hz : (n_frequencies,) array [Hz]
        Without 0.
    singular_value : (n_frequencies, n_values) array [(m/s²)²/Hz]
        Falling along axis 1, one-sided density.
    """

    frequency_hz: NDArray[np.float64]
    singular_value: NDArray[np.float64]


def singular_value_spectrum(
    samples: Samples, max_frequency_hz: float | None = None, n_values: int = N_VALUES
) -> SingularValueSpectrum:
    """Return the singular values of Welch's estimate with half-overlapping Hann segments.

    Parameters
    ----------
    samples : Samples
        Of any length from 16 rows.
    max_frequency_hz : float [Hz] or None
        Where to stop; None: at half the sample rate.
    n_values : int
        How many singular values.

    References
    ----------
    Welch (1967), doi:10.1109/TAU.1967.1161901;
    Brincker, Zhang and Andersen (2001), doi:10.1088/0964-1726/10/3/303 (singular values).
    """
    rate, data = samples.sample_rate_hz, samples.acceleration
    length = max(16, int(min(LONGEST_SEGMENT_S * rate, 2 * len(data) / (FEWEST_SEGMENTS + 1))))
    length = min(next_fast_len(length, real=True), len(data))
    taper = hann(length)
    scale = 2.0 / (rate * np.sum(taper**2))
    frequency = np.fft.rfftfreq(length, 1.0 / rate)
    keep = slice(1, int(np.searchsorted(frequency, max_frequency_hz or rate, side='right')))
    step = max(1, length // 2)
    n_segments = (len(data) - length) // step + 1
    taper = (taper * math.sqrt(scale / n_segments)).astype(np.float32)
    # Singular values of the density matrix: those of its square root, the segments' lines.  With
    # fewer segments than channels their products are sums over the channels.
    n_channels = data.shape[1]
    by_segment = n_channels > n_segments
    at_once = max(1, VALUES_AT_ONCE // len(data)) if by_segment else n_channels
    products: list[NDArray[np.complex64]] = []
    for first in range(0, n_channels, at_once):
        rows = _centred(samples.widened(columns=slice(first, first + at_once)))
        segments = sliding_window_view(rows, length, axis=1)[:, ::step]
        lines = rfft(segments * taper, axis=2)[:, :, keep].transpose(2, 1, 0)
        part = _products(lines if by_segment else lines.transpose(0, 2, 1))
        products = [products[0] + part] if products else [part]
    values = np.linalg.eigvalsh(products[0])
    falling: NDArray[np.float64] = np.maximum(values[:, ::-1][:, :n_values], 0.0)
    return SingularValueSpectrum(np.asarray(frequency[keep], dtype=np.float64), falling)


def _centred(data: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return channels as rows, without their means."""
    # Single precision: half the time, and a picture needs no more.
    mean = np.ones(len(data)) @ data / len(data)
    rows = np.empty(data.shape[::-1], dtype=np.float32)
    for first in range(0, len(data), ROWS_AT_ONCE):
        part = data[first : first + ROWS_AT_ONCE]
        rows[:, first : first + len(part)] = (part - mean).T
    return rows


def _products(lines: NDArray[np.complex64]) -> NDArray[np.complex64]:
    """Return the products of the rows with one another, (n_lines, n_rows, n_rows)."""
    found = np.empty((*lines.shape[:2], lines.shape[1]), dtype=lines.dtype)
    for first in range(0, len(lines), LINES_AT_ONCE):
        root = np.ascontiguousarray(lines[first : first + LINES_AT_ONCE])
        found[first : first + LINES_AT_ONCE] = root @ root.conj().transpose(0, 2, 1)
    return found


class SlidingSpectrum:
    """Spectra of windows that overlap; one that hardly differs from the last is not made again.

    Parameters
    ----------
    max_frequency_hz : float [Hz] or None
        As for :func:`singular_value_spectrum`.
    refreshed : float
        Share of a window that is new when its spectrum is made again; 1: every sample once.
    """

    def __init__(
        self, max_frequency_hz: float | None = None, refreshed: float = REFRESHED
    ) -> None:
        self._max_frequency_hz = max_frequency_hz
        self._refreshed = refreshed
        self._of: Samples | None = None
        self._last = empty_spectrum()

    def of(self, samples: Samples) -> SingularValueSpectrum:
        """Return the spectrum of a window, or of one before it that is nearly the same."""
        if self._of is None or not self._nearly(self._of, samples):
            self._last = singular_value_spectrum(samples, self._max_frequency_hz)
            self._of = replace(samples, acceleration=samples.acceleration[:0].copy())
        return self._last

    def _nearly(self, first: Samples, second: Samples) -> bool:
        same = first.channels == second.channels and first.sample_rate_hz == second.sample_rate_hz
        passed_s = (second.start_ns - first.start_ns) / NANOSECONDS_PER_SECOND
        return same and 0.0 < passed_s < self._refreshed * second.duration_s


def empty_spectrum() -> SingularValueSpectrum:
    """Return a spectrum without lines."""
    return SingularValueSpectrum(np.empty(0), np.empty((0, N_VALUES)))
