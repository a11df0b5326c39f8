"""Which channels serve as references."""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr

MOST_REFERENCES = 12
LAGS = (1, 2, 3, 5, 8, 13, 21, 34)
LONGEST = 20000


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
    wanted = min(n_references or MOST_REFERENCES, n_channels)
    if wanted == n_channels:
        return np.arange(n_channels)
    rows = rows[:LONGEST]
    scale = rows.std(axis=0)
    scaled = rows / np.where(scale > 0.0, scale, np.inf)
    lags = [lag for lag in LAGS if lag < len(rows) // 4]
    covariances = np.concatenate([scaled[lag:].T @ scaled[:-lag] for lag in lags])
    pivots = qr(covariances, mode='r', pivoting=True)[1]
    return np.sort(np.asarray(pivots[:wanted], dtype=np.int64))
