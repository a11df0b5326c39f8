"""Which channels serve as references."""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr

from oma_identifier.covariance.thresholds import COVARIANCE


def choose_references(rows: NDArray[np.float64], n_references: int | None) -> NDArray[np.int64]:
    """Return the channels whose lagged covariances say the most that others do not.

    Pivoted QR on the covariances at positive lags: sensor noise has none there, so a channel of
    noise is never chosen, and a channel that repeats another adds nothing.

    Parameters
    ----------
    rows : (n_samples, n_channels) array
        Conditioned samples.
    n_references : int or None
        How many; None: all, at most a dozen.

    Returns
    -------
    (n_references,) int array
        Columns, rising.
    """
    n_channels = rows.shape[1]
    wanted = min(n_references or COVARIANCE.most_references, n_channels)
    if wanted == n_channels:
        return np.arange(n_channels)
    scaled = rows[: COVARIANCE.looked_at] * _inverse_scale(rows)
    pivots = qr(_covariances(scaled), mode='r', pivoting=True)[1]
    return np.sort(np.asarray(pivots[:wanted], dtype=np.int64))


def _inverse_scale(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return one over the standard deviation of each channel, 0 where nothing moves."""
    scale = rows[: COVARIANCE.looked_at].std(axis=0)
    inverse = np.zeros(len(scale))
    return np.asarray(np.divide(1.0, scale, out=inverse, where=scale > 0.0))


def _covariances(scaled: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return covariances of all channels with all at a few lags, one below the other."""
    lags = [lag for lag in COVARIANCE.lags if lag < max(2, len(scaled) // 4)]
    return np.asarray(np.concatenate([scaled[lag:].T @ scaled[:-lag] for lag in lags]))
