"""Sums of products of two series at many lags."""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft

FEW_PAIRS = 100
"""More pairs of channels than this make products of matrices faster on short series."""
SEGMENT_LAGS = 6
"""Length of a transform in multiples of the number of lags."""
SEGMENTS_AT_ONCE = 32
LONG = 4
"""Segments from where on transforms are faster however many channels there are."""


def lagged_sums(
    ahead: NDArray[np.float64], rows: NDArray[np.float64], n_lags: int
) -> NDArray[np.float64]:
    """Return Σ_t a(t+d) x(t)ᵀ for d = 0 .. n_lags - 1, t over all rows of x.

    Parameters
    ----------
    ahead : (n_samples + n_lags - 1, n_ahead) array
        Series a; further rows are not used.
    rows : (n_samples, n_channels) array
        Series x.

    Returns
    -------
    (n_lags, n_ahead, n_channels) array
        Exact up to rounding: nothing wraps around.
    """
    n_samples, n_channels = rows.shape
    length = next_fast_len(min(SEGMENT_LAGS * n_lags, n_samples + n_lags), real=True)
    if ahead.shape[1] * n_channels > FEW_PAIRS and n_samples < LONG * length:
        sums = np.empty((n_lags, ahead.shape[1], n_channels))
        for lag in range(n_lags):
            np.matmul(ahead[lag : lag + n_samples].T, rows, out=sums[lag])
        return sums
    # Overlap-save: each segment of x sees all of a that it is multiplied with.
    step = length - n_lags + 1
    n_whole = n_samples // step
    spectrum = np.zeros((length // 2 + 1, ahead.shape[1], n_channels), dtype=complex)
    windows = sliding_window_view(ahead, length, axis=0)[::step] if n_whole else ahead[:0]
    for first in range(0, n_whole, SEGMENTS_AT_ONCE):
        last = min(n_whole, first + SEGMENTS_AT_ONCE)
        part = rows[first * step : last * step].reshape(last - first, step, n_channels)
        later = rfft(windows[first:last], axis=2)
        now = rfft(part, length, axis=1)
        spectrum += later.transpose(2, 1, 0) @ now.conj().transpose(1, 0, 2)
    rest = rows[n_whole * step :]
    if len(rest):
        later = rfft(ahead[n_whole * step :][: len(rest) + n_lags - 1], length, axis=0)
        spectrum += later[:, :, None] * rfft(rest, length, axis=0).conj()[:, None]
    return np.asarray(irfft(spectrum, length, axis=0)[:n_lags])
