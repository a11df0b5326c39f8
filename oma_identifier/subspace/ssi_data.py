"""Data-driven stochastic subspace identification (unweighted principal components).

The future outputs are projected on the past references.  Only the column space of the projection
matters, and it is that of H L⁻ᵀ, with H the product of future and past and L Lᵀ that of the past
with itself.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cholesky, solve_triangular

from oma_identifier.covariance import HankelGram
from oma_identifier.subspace.ssi_cov import (
    HankelFactors,
    MultiOrder,
    poles_of_orders,
    RawPoles,
    singular_triplets,
)

RIDGE = 1e-10
"""Of the mean square; keeps the factor of the past defined when channels repeat each other."""


def ssi_data(
    rows: NDArray[np.float64],
    references: NDArray[np.int64],
    block_rows: int,
    orders: Sequence[int],
) -> RawPoles:
    """Return the poles of all model orders.

    Parameters
    ----------
    rows : (n_samples, n_channels) array
        Conditioned responses.
    references : (n_references,) int array
        Columns whose past is used.
    block_rows : int
        Block rows of future and of past.
    orders : sequence of int
        Model orders.

    References
    ----------
    Van Overschee and De Moor (1996), Subspace Identification for Linear Systems, Kluwer;
    Peeters and De Roeck (1999), doi:10.1006/mssp.1999.1249 (reference-based).
    """
    return data_poles(data_gram(rows, references, block_rows), references, block_rows, orders)


def data_gram(
    rows: NDArray[np.float64], references: NDArray[np.int64], block_rows: int
) -> HankelGram:
    """Return all that :func:`data_poles` needs of the rows, see :func:`ssi_data`."""
    return HankelGram(rows, rows[:, references], 2 * block_rows)


def data_poles(
    gram: HankelGram, references: NDArray[np.int64], block_rows: int, orders: Sequence[int]
) -> RawPoles:
    """Return the poles of all model orders, see :func:`ssi_data`."""
    past, future = range(block_rows), range(block_rows, 2 * block_rows)
    of = np.asarray(references, dtype=np.intp)
    triangle = triangular_factor(gram.gram(past, of))
    projection = solve_triangular(
        triangle, gram.product(future, past).T, lower=True, check_finite=False
    ).T
    return poles_of_projection(projection, gram.n_left, len(references), orders)


def triangular_factor(gram: NDArray[np.float64], ridge: float = RIDGE) -> NDArray[np.float64]:
    """Return the lower Cholesky factor of a Gram matrix that may be singular.

    Parameters
    ----------
    gram : (n, n) array
        Without directions below zero.
    ridge : float
        Added to its diagonal, over the mean of that.
    """
    added = ridge * np.trace(gram) / len(gram) * np.eye(len(gram))
    return np.asarray(cholesky(gram + added, lower=True, check_finite=False))


def poles_of_projection(
    projection: NDArray[np.float64], n_channels: int, n_references: int, orders: Sequence[int]
) -> RawPoles:
    """Return the poles of all orders from a matrix with the column space of the observability.

    Parameters
    ----------
    projection : (block_rows * n_channels, n_columns) array
        Any matrix with that column space.
    n_channels, n_references : int
        Channels of one block row; of one block column.
    orders : sequence of int
        Model orders.
    """
    n_kept = min(orders[-1], len(projection) - n_channels)
    left, values, right = singular_triplets(projection, n_kept)
    system = MultiOrder(HankelFactors(left, values, right, n_channels, n_references), orders[-1])
    solutions = [system.solve(order) for order in orders if order <= system.highest]
    return poles_of_orders(solutions, left[:n_channels])
