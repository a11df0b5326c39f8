"""Half spectra: the Fourier transform of the output covariances at positive lags.

Unlike a Welch spectrum, a half spectrum has the poles of the structure once, and its only
distortion is the exponential window on the lags, which is removed from the poles exactly.  Lag 0,
with the sensor noise in it, is left out.
"""

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft

from oma_identifier.methods.thresholds import METHOD


@dataclass(frozen=True, slots=True)
class HalfSpectra:
    """Half spectra at equidistant points of the upper half of the unit circle.

    Parameters
    ----------
    angle : (n_lines,) array [rad]
        Angular frequency times the sampling interval.
    value : (n_lines, n_channels, n_references) complex array
        Σ_k R_k exp(-(i·angle + decay) k), k = 1 .. n_lags.
    decay : float
        Of the exponential window, per lag.
    """

    angle: NDArray[np.float64]
    value: NDArray[np.complex128]
    decay: float


def half_spectra(covariance: NDArray[np.float64], low: float, high: float) -> HalfSpectra:
    """Return the half spectra between two frequencies.

    Parameters
    ----------
    covariance : (n_lags + 1, n_channels, n_references) array
        R_0 .. R_n_lags of the responses with the references.
    low, high : float
        Ends of the band as fractions of the sample rate.

    References
    ----------
    Peeters, Van der Auweraer, Guillaume and Leuridan (2004), doi:10.1155/2004/523692 (PolyMAX);
    Cauberghe (2004), PhD thesis, Vrije Universiteit Brussel, section 3.3 (half spectra).
    """
    n_lags = len(covariance) - 1
    decay = -math.log(METHOD.end_of_window) / n_lags
    window = np.exp(-decay * np.arange(n_lags + 1))
    window[0] = 0.0
    n_fft = 2 * n_lags
    value = rfft(covariance * window[:, None, None], n_fft, axis=0)
    fraction = np.arange(len(value)) / n_fft
    keep = (fraction >= low) & (fraction <= high)
    return HalfSpectra(2.0 * np.pi * fraction[keep], value[keep], decay)


class LagSums:
    """Products of responses with references before them, summed lag by lag over a record.

    Exact sums, by overlapping segments whose cross spectra are added before the one inverse
    transform, so that many lags of many channels cost little time and memory.

    Parameters
    ----------
    rows : (n_samples, n_channels) array
        Conditioned responses.
    references : (n_references,) int array
        Columns that serve as references.
    n_lags : int
        Longest lag.
    """

    def __init__(
        self, rows: NDArray[np.float64], references: NDArray[np.int64], n_lags: int
    ) -> None:
        self._n_lags = n_lags
        self._n_fft = next_fast_len(8 * n_lags, real=True)
        silence = np.zeros((n_lags, len(references)))
        past = np.concatenate([silence, rows[:, references]])
        self._total = self._shifts(self._cross_spectrum(rows, past, self._n_fft), self._n_fft)
        # A stretch that is left out changes little, which need not be known precisely.
        self._rows, self._past = rows.astype(np.float32), past.astype(np.float32)

    def covariance(self, left_out: tuple[int, int] | None = None) -> NDArray[np.float64]:
        """Return R_k, k = 0 .. n_lags, (n_lags + 1, n_channels, n_references) array.

        Parameters
        ----------
        left_out : (first, last) or None
            Rows of a stretch that has no part in it, neither as response nor as reference.
        """
        lags, n_rows = np.arange(self._n_lags + 1), len(self._rows)
        counts = n_rows - lags
        if left_out is None:
            return np.asarray(self._total / counts[:, None, None])
        first, last = left_out
        end = min(last + self._n_lags, n_rows)
        # All that ends in the stretch or within reach of it, but what has not begun in it.
        n_fft = min(self._n_fft, next_fast_len(end - first + self._n_lags, real=True))
        spectrum = self._cross_spectrum(
            self._rows[first:end], self._past[first : end + self._n_lags], n_fft
        )
        beside = self._past[last : end + self._n_lags].copy()
        beside[max(0, first - last + self._n_lags) : self._n_lags] = 0.0
        spectrum -= self._cross_spectrum(self._rows[last:end], beside, n_fft)
        ends = _length(np.maximum(first, lags), last)
        begins = _length(first + lags, np.minimum(last + lags, n_rows))
        counts -= ends + begins - _length(first + lags, last)
        return np.asarray((self._total - self._shifts(spectrum, n_fft)) / counts[:, None, None])

    def _cross_spectrum(
        self, rows: NDArray[np.floating], past: NDArray[np.floating], n_fft: int
    ) -> NDArray[np.complexfloating]:
        """Return the spectrum of Σ_t r(t-k) y(t); the references begin ``n_lags`` earlier."""
        n_lags = self._n_lags
        step = n_fft - n_lags
        shape = (n_fft // 2 + 1, rows.shape[1], past.shape[1])
        total = np.zeros(shape, np.result_type(rows.dtype, np.complex64))
        for start in range(0, len(rows), step):
            now = rfft(rows[start : start + step], n_fft, axis=0)
            before = rfft(past[start : start + step + n_lags], n_fft, axis=0)
            total += now[:, :, None].conj() * before[:, None, :]
        return total

    def _shifts(self, spectrum: NDArray[np.complexfloating], n_fft: int) -> NDArray[np.floating]:
        return np.asarray(irfft(spectrum, n_fft, axis=0)[self._n_lags :: -1])


def _length(first: NDArray[np.int64], last: NDArray[np.int64] | int) -> NDArray[np.int64]:
    """Return how many whole numbers there are from the first on below the last."""
    return np.maximum(last - first, 0)
