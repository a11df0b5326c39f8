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

END_OF_WINDOW = 0.01
"""Value of the exponential window at the longest lag."""


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


def half_spectra(
    rows: NDArray[np.float64],
    references: NDArray[np.int64],
    n_lags: int,
    low: float,
    high: float,
) -> HalfSpectra:
    """Return the half spectra between two frequencies.

    Parameters
    ----------
    rows : (n_samples, n_channels) array
        Conditioned responses.
    references : (n_references,) int array
        Columns that serve as references.
    n_lags : int
        Longest lag.
    low, high : float
        Ends of the band as fractions of the sample rate.

    References
    ----------
    Peeters, Van der Auweraer, Guillaume and Leuridan (2004), doi:10.1155/2004/523692 (PolyMAX);
    Cauberghe (2004), PhD thesis, Vrije Universiteit Brussel, section 3.3 (half spectra).
    """
    covariance = segment_covariance(rows, references, n_lags)
    decay = -math.log(END_OF_WINDOW) / n_lags
    window = np.exp(-decay * np.arange(n_lags + 1))
    window[0] = 0.0
    n_fft = 2 * n_lags
    value = rfft(covariance * window[:, None, None], n_fft, axis=0)
    fraction = np.arange(len(value)) / n_fft
    keep = (fraction >= low) & (fraction <= high)
    return HalfSpectra(2.0 * np.pi * fraction[keep], value[keep], decay)


def segment_covariance(
    rows: NDArray[np.float64], references: NDArray[np.int64], n_lags: int
) -> NDArray[np.float64]:
    """Return R_k, k = 0 .. n_lags, (n_lags + 1, n_channels, n_references) array.

    Exact sums, by overlapping segments whose cross spectra are added before the one inverse
    transform, so that many lags of many channels cost little time and memory.
    """
    n_fft = next_fast_len(8 * n_lags, real=True)
    step = n_fft - n_lags
    total = np.zeros((n_fft // 2 + 1, rows.shape[1], len(references)), dtype=complex)
    for start in range(0, len(rows), step):
        now = rows[start : start + step]
        # y(t) r(t-k): the references of the segment and of n_lags samples before it.
        before = rows[max(0, start - n_lags) : start + step, references]
        lead = np.zeros((n_lags - min(start, n_lags), len(references)))
        outputs = rfft(now, n_fft, axis=0)
        inputs = rfft(np.concatenate([lead, before]), n_fft, axis=0)
        total += outputs[:, :, None].conj() * inputs[:, None, :]
    shifts = irfft(total, n_fft, axis=0)[: n_lags + 1]
    counts = len(rows) - np.arange(n_lags + 1)
    return np.asarray(shifts[::-1] / counts[:, None, None])
