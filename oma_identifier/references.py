"""Which channels, or combinations of channels, serve as references."""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh, qr

MOST_REFERENCES = 12
MOST_COMBINATIONS = 8
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
    scaled = rows[:LONGEST] * _inverse_scale(rows[:LONGEST])
    pivots = qr(_covariances(scaled), mode='r', pivoting=True)[1]
    return np.sort(np.asarray(pivots[:wanted], dtype=np.int64))


def combine_references(rows: NDArray[np.float64], n_references: int | None) -> NDArray[np.float64]:
    """Return the combinations of channels that serve as references.

    Few references are channels.  More of them are reduced to the few orthonormal combinations
    that hold most of their lagged covariances: a band holds no more modes than that, and what is
    left out is sensor noise.

    Parameters
    ----------
    rows : (n_samples, n_channels) array
        Conditioned samples.
    n_references : int or None
        Channels to use; None: all.

    Returns
    -------
    (n_channels, n_combinations) array
        Reference signals are ``rows @ combinations``, of channels scaled to unit variance.
    """
    rows = rows[:LONGEST]
    inverse = _inverse_scale(rows)
    chosen = choose_references(rows, n_references or rows.shape[1])
    combinations = np.zeros((rows.shape[1], len(chosen)))
    combinations[chosen, np.arange(len(chosen))] = inverse[chosen]
    if len(chosen) <= MOST_COMBINATIONS:
        return np.asarray(combinations)
    covariances = _covariances(rows @ combinations)
    strongest = (len(chosen) - MOST_COMBINATIONS, len(chosen) - 1)
    vectors = eigh(covariances.T @ covariances, subset_by_index=strongest)[1]
    return np.asarray(combinations @ vectors[:, ::-1])


def _inverse_scale(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    scale = rows.std(axis=0)
    inverse = np.zeros(len(scale))
    return np.asarray(np.divide(1.0, scale, out=inverse, where=scale > 0.0))


def _covariances(scaled: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return covariances of all channels with all at a few lags, one below the other."""
    lags = [lag for lag in LAGS if lag < len(scaled) // 4]
    return np.asarray(np.concatenate([scaled[lag:].T @ scaled[:-lag] for lag in lags]))
