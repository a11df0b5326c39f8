"""Sums of products of two series at many lags."""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft

FEW_PAIRS, FEW_LAGS = 100, 100
"""More pairs of channels, or fewer lags, make a product of matrices faster on short series."""
ROWS_AT_ONCE = 512
SEGMENT_LAGS = 6
"""Length of a transform in multiples of the number of lags."""
SEGMENTS_AT_ONCE = 32
LONG = 4
"""Segments from where on transforms are faster however many channels and lags there are."""


def lagged_sums(
    ahead: NDArray[np.floating], rows: NDArray[np.floating], n_lags: int
) -> NDArray[np.floating]:
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
        Exact up to rounding: nothing wraps around.  As precise as the series.
    """
    n_samples, n_channels = rows.shape
    length = next_fast_len(min(SEGMENT_LAGS * n_lags, n_samples + n_lags), real=True)
    suits_product = ahead.shape[1] * n_channels > FEW_PAIRS or n_lags < FEW_LAGS
    if suits_product and n_samples < LONG * length:
        return _product(ahead, rows, n_lags)
    # Overlap-save: each segment of x sees all of a that it is multiplied with.
    step = length - n_lags + 1
    n_whole = n_samples // step
    shape = (length // 2 + 1, ahead.shape[1], n_channels)
    spectrum = np.zeros(shape, np.result_type(rows.dtype, np.complex64))
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


def _product(
    ahead: NDArray[np.floating], rows: NDArray[np.floating], n_lags: int
) -> NDArray[np.floating]:
    """Return the sums as products with all that is ahead of a row, side by side."""
    n_ahead = ahead.shape[1]
    flat = np.ascontiguousarray(ahead).reshape(-1)
    views = sliding_window_view(flat, n_lags * n_ahead)[::n_ahead]
    sums = np.zeros((rows.shape[1], n_lags * n_ahead), rows.dtype)
    for first in range(0, len(rows), ROWS_AT_ONCE):
        part = rows[first : first + ROWS_AT_ONCE]
        sums += part.T @ np.ascontiguousarray(views[first : first + len(part)])
    return sums.reshape(-1, n_lags, n_ahead).transpose(1, 2, 0)
