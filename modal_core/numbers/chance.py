"""Probabilities by chance."""

import numpy as np
from numpy.typing import NDArray
from scipy.special import fdtr, fdtrc

Real = NDArray[np.float64]


def fisher_tail(ratio: float | Real, above: float | Real, below: float | Real) -> Real:
    """Return the probability that two mean powers differ by more than a ratio.

    Parameters
    ----------
    ratio : float or array
        At least 0.
    above, below : float or array
        Degrees of freedom of the numerator and of the denominator.
    """
    return np.asarray(fdtrc(above, below, ratio), dtype=np.float64)


def fisher_share(ratio: float | Real, above: float, below: float) -> Real:
    """Return the probability that the ratio of two mean powers is smaller than this one."""
    return np.asarray(fdtr(above, below, ratio), dtype=np.float64)
