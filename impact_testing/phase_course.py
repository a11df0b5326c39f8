"""The course of a phase whose frequency wanders, by what was seen of it, in linear time.

The state of a block is the phase and its step to the next; the step is a random walk.  Two blocks
that follow each other are tied, so that the equations of all have a narrow band.

References
----------
Rue and Held (2005), Gaussian Markov Random Fields, sections 2.4 (bands) and 2.3.2 (variances).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_solve_banded, cholesky_banded

Real = NDArray[np.float64]
BAND = 3
"""Unknowns after one that it is tied to: the other of its block, and both of the next."""


def course_of(
    step_s: float, seen: Real, variance: Real, paces: Sequence[float]
) -> tuple[Real, Real]:
    """Return the most likely course of a phase and its variance.

    Parameters
    ----------
    step_s : float [s]
        From one block to the next.
    seen : (n_blocks,) array [rad]
        The phase in each.
    variance : (n_blocks,) array [rad²]
        Of what was seen.
    paces : sequence of float [rad/s per √s]
        Of the random walk of the frequency, none negative; that of largest restricted likelihood
        counts.  0: the frequency stays.

    Returns
    -------
    course, variance : (n_blocks,) array [rad], [rad²]
    """
    walks = [_walk(step_s, seen, variance, pace) for pace in paces if pace > 0.0]
    best = min([_straight(seen, variance), *walks], key=lambda each: each.cost)
    return best.course, best.variance()


@dataclass(frozen=True)
class _Fit:
    """A course at some pace.

    Parameters
    ----------
    cost : float
        -2 log of the restricted likelihood, but for a constant.
    course : (n_blocks,) array [rad]
    variance : callable
        Gives that of the course [rad²].
    """

    cost: float
    course: Real
    variance: Callable[[], Real]


def _straight(seen: Real, variance: Real) -> _Fit:
    """Fit a phase whose step stays."""
    free = np.stack([np.ones_like(seen), np.arange(len(seen))], axis=1)
    gram = (free.T / variance) @ free
    course = free @ np.linalg.solve(gram, free.T @ (seen / variance))
    cost = float(np.sum((seen - course) ** 2 / variance) + np.linalg.slogdet(gram)[1])
    return _Fit(cost, course, lambda: np.sum(free.T * np.linalg.solve(gram, free.T), axis=0))


def _walk(step_s: float, seen: Real, variance: Real, pace: float) -> _Fit:
    """Fit a phase whose step walks at random."""
    n = len(seen)
    # From one block to the next: [[1/3, 1/2], [1/2, 1]] h³ pace² is the covariance.
    scale = pace**2 * step_s**3
    tie = np.array([[12.0, -6.0], [-6.0, 4.0]]) / scale
    ahead = np.array([[1.0, 1.0], [0.0, 1.0]])
    before, between = ahead.T @ tie @ ahead, -tie @ ahead
    blocks = np.zeros((n, 2, 2))
    blocks[:-1] += before
    blocks[1:] += tie
    blocks[:, 0, 0] += 1.0 / variance
    # Row d of a band holds what lies d below the diagonal.
    band = np.zeros((BAND + 1, 2 * n))
    band[0, ::2], band[0, 1::2], band[1, ::2] = blocks[:, [0, 1, 1], [0, 1, 0]].T
    band[1, 1:-1:2], band[3, :-2:2] = between[0, 1], between[1, 0]
    band[2, :-2:2], band[2, 1:-2:2] = between[0, 0], between[1, 1]
    pull = np.zeros(2 * n)
    pull[::2] = seen / variance
    factor = cholesky_banded(band, lower=True)
    course = cho_solve_banded((factor, True), pull)[::2]
    cost = float((seen - course) @ (seen / variance)) + 2.0 * float(np.log(factor[0]).sum())
    cost += (n - 1) * float(2.0 * np.log(scale) - np.log(12.0))
    return _Fit(cost, course, lambda: _diagonal_of_inverse(factor)[::2])


def _diagonal_of_inverse(factor: Real) -> Real:
    """Return the diagonal of (L Lᵀ)⁻¹ of a band, from the last unknown to the first."""
    size = factor.shape[1]
    columns = factor.T.tolist()
    # Row j: the inverse at (j, j), (j, j + 1), ... as far as the band goes.
    inverse = [[0.0] * (BAND + 1) for _ in range(size + BAND)]
    for j in range(size - 1, -1, -1):
        top, *below = columns[j]
        for i in range(BAND, -1, -1):
            ahead = sum(
                each * inverse[j + min(k, i)][abs(k - i)] for k, each in enumerate(below, 1)
            )
            inverse[j][i] = ((1.0 / top if i == 0 else 0.0) - ahead) / top
    return np.array([row[0] for row in inverse[:size]])
