"""How well samples follow from those before them: a short autoregressive model of one channel.

What a structure does over a few steps is linear, whatever its modes; a fault of the converter is
not, and shows in what such a model does not predict (Makhoul, Linear prediction, 1975: covariance
method).
"""

import numpy as np
from numpy.typing import NDArray

ORDER = 12
"""Six modes; more of them are predicted less well, faulty or not."""
KEPT = 0.6
"""Share of the rows, those predicted best, that a robust model is made of."""
TRIMS = 16
RIDGE = 1e-9

Real = NDArray[np.float64]


def lagged(signal: Real) -> Real:
    """Return a channel beside its past, (ORDER + 1, n_rows - ORDER) array; the newest last."""
    centred = signal - signal.mean()
    n_rows = len(centred) - ORDER
    return np.array([centred[lag : lag + n_rows] for lag in range(ORDER + 1)])


def innovations(past: Real) -> Real:
    """Return what a least-squares model does not predict, (n_rows,) array.

    Parameters
    ----------
    past : (ORDER + 1, n_rows) array
        See `lagged`.
    """
    return _errors(past, past)


def robust_innovations(past: Real) -> Real:
    """Return the same of a model made of the rows it predicts best (least trimmed squares)."""
    error = innovations(past)
    for _ in range(TRIMS):
        size = np.abs(error)
        place = int(KEPT * len(size))
        error = _errors(past, past[:, size <= np.partition(size, place)[place]])
    return error


def _errors(past: Real, learned: Real) -> Real:
    product = learned @ learned.T
    gram = product[:-1, :-1] + RIDGE * np.trace(product) / ORDER * np.eye(ORDER)
    weights = np.linalg.solve(gram, product[:-1, -1])
    return np.asarray(past[-1] - weights @ past[:-1])
