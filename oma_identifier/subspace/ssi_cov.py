"""Reference-based covariance-driven stochastic subspace identification, all orders at once.

References
----------
Peeters and De Roeck (1999), doi:10.1006/mssp.1999.1249 (reference-based SSI-cov);
Döhler and Mevel (2012), doi:10.1016/j.conengprac.2012.02.005 (one QR for all model orders).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh, qr, solve_triangular


@dataclass(frozen=True, slots=True)
class HankelFactors:
    """Singular triplets of the block Hankel matrix H = U S Vᵀ.

    Parameters
    ----------
    left : (block_rows * n_outputs, n_kept) array
        Singular vectors.
    values : (n_kept,) array
        Singular values, falling.
    right : (block_columns * n_references, n_kept) array
        Singular vectors.
    n_outputs, n_references : int
        Size of one block.
    left_root, right_root : square array or None
        Lower triangular L and K where the triplets are those of L⁻¹ H K⁻ᵀ instead.
    """

    left: NDArray[np.float64]
    values: NDArray[np.float64]
    right: NDArray[np.float64]
    n_outputs: int
    n_references: int
    left_root: NDArray[np.float64] | None = None
    right_root: NDArray[np.float64] | None = None

    @property
    def observability(self) -> NDArray[np.float64]:
        """A basis of the columns of H, (block_rows * n_outputs, n_kept)."""
        return self.left if self.left_root is None else self.left_root @ self.left

    @property
    def columns(self) -> NDArray[np.float64]:
        """The combinations of columns of H that this basis is, (columns of H, n_kept)."""
        root = self.right_root
        right = self.right if root is None else back_substituted(root, self.right)
        return np.asarray(right / self.values)


@dataclass(frozen=True, slots=True)
class RawPoles:
    """Discrete-time poles of all model orders.

    Parameters
    ----------
    model_order : (n_poles,) int array
        State-space order.
    eigenvalue : (n_poles,) complex array
        Upper half plane.
    shape : (n_channels, n_poles) complex array
        In units of the scaled channels.
    """

    model_order: NDArray[np.int64]
    eigenvalue: NDArray[np.complex128]
    shape: NDArray[np.complex128]


def block_hankel(covariance: NDArray[np.float64], block_rows: int) -> NDArray[np.float64]:
    """Return the block Hankel matrix with R_{p+q+1} in block (p, q).

    Parameters
    ----------
    covariance : (n_lags, n_channels, n_references) array
        R_1 .. R_n_lags.
    block_rows : int
        Block rows; n_lags + 1 - block_rows block columns follow.
    """
    n_lags, n_channels, n_references = covariance.shape
    columns = n_lags + 1 - block_rows
    index = np.arange(block_rows)[:, None] + np.arange(columns)
    blocks = covariance[index]
    return np.asarray(
        blocks.transpose(0, 2, 1, 3).reshape(block_rows * n_channels, columns * n_references)
    )


def factorise(covariance: NDArray[np.float64], block_rows: int) -> HankelFactors:
    """Return the singular triplets of the block Hankel matrix.

    The eigenvalues of HᵀH are as good as a singular value decomposition here: what matters lies
    within a few decades of the largest singular value, the rest is estimation noise.
    """
    _, n_channels, n_references = covariance.shape
    left, values, right = singular_triplets(block_hankel(covariance, block_rows))
    return HankelFactors(left, values, right, n_channels, n_references)


def singular_triplets(
    matrix: NDArray[np.float64], most: int | None = None
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return left vectors, values and right vectors, of the most values above rounding."""
    squares, vectors = np.linalg.eigh(matrix.T @ matrix)
    n_kept = min(*matrix.shape, most or len(matrix))
    values = np.sqrt(np.maximum(squares[::-1][:n_kept], 0.0))
    right = vectors[:, ::-1][:, :n_kept]
    keep = values > 1e-7 * values[0]
    values, right = values[keep], right[:, keep]
    return (matrix @ right) / values, values, right


def back_substituted(
    root: NDArray[np.float64], vectors: NDArray[np.floating]
) -> NDArray[np.float64]:
    """Return L⁻ᵀ times vectors, of a lower triangular L."""
    return np.asarray(solve_triangular(root, vectors, lower=True, trans='T', check_finite=False))


@dataclass(frozen=True, slots=True)
class OrderSolution:
    """Transition matrix of one model order, diagonalised.

    Parameters
    ----------
    order : int
        State-space order n.
    eigenvalue : (n,) complex array
        Discrete-time poles, both of each pair.
    vector : (n, n) complex array
        Right eigenvectors as columns.
    """

    order: int
    eigenvalue: NDArray[np.complex128]
    vector: NDArray[np.complex128]


class MultiOrder:
    """Transition matrices of all model orders from one QR decomposition.

    The observability matrix of order n is made of the first n singular vectors, so its QR
    decomposition is a corner of that of the highest order.

    Parameters
    ----------
    factors : HankelFactors
        Of the block Hankel matrix.
    highest : int
        Highest model order; less when there are fewer singular vectors, or rows to shift by one
        block.
    """

    def __init__(self, factors: HankelFactors, highest: int) -> None:
        self.factors = factors
        size = factors.n_outputs
        self.highest = min(highest, len(factors.values), len(factors.left) - size)
        self.observability = factors.observability[:, : self.highest]
        self.orthogonal, self.triangle = qr(
            self.observability[:-size], mode='economic', check_finite=False
        )
        # A corner of the inverse is the inverse of the corner.
        self.inverse = solve_triangular(self.triangle, np.eye(self.highest), check_finite=False)
        self._shifted = self.orthogonal.T @ self.observability[size:]

    def solve(self, order: int) -> OrderSolution:
        """Return the poles of one model order."""
        transition = self.inverse[:order, :order] @ self._shifted[:order, :order]
        value, vector = np.linalg.eig(transition)
        return OrderSolution(order, np.asarray(value, dtype=complex), vector.astype(complex))


def poles_of_orders(solutions: Sequence[OrderSolution], output: NDArray[np.float64]) -> RawPoles:
    """Return the poles of the upper half plane of every model order.

    Parameters
    ----------
    solutions : sequence of OrderSolution
        One per model order.
    output : (n_channels, n_kept) array
        Output matrix in the coordinates of the singular vectors.
    """
    order_of, eigenvalues, shapes = [], [], []
    for solution in solutions:
        upper = solution.eigenvalue.imag > 0.0
        order_of.append(np.full(np.count_nonzero(upper), solution.order))
        eigenvalues.append(solution.eigenvalue[upper])
        vectors = solution.vector[:, upper]
        left = output[:, : solution.order]
        shapes.append(left @ vectors.real + 1j * (left @ vectors.imag))
    return RawPoles(
        model_order=np.concatenate(order_of),
        eigenvalue=np.concatenate(eigenvalues),
        shape=np.concatenate(shapes, axis=1),
    )


def compress_outputs(covariance: NDArray[np.float64], n_outputs: int) -> NDArray[np.float64]:
    """Return the orthonormal combinations of channels that hold most of the covariances.

    A band holds fewer independent shapes than a dense sensor set has channels; the combinations
    left out are noise.

    Parameters
    ----------
    covariance : (n_lags, n_channels, n_references) array
        Positive lags.
    n_outputs : int
        How many combinations.

    Returns
    -------
    (n_channels, n_outputs) array
        Columns are orthonormal.
    """
    wide = covariance.transpose(1, 0, 2).reshape(covariance.shape[1], -1)
    n_channels = len(wide)
    first = max(0, n_channels - n_outputs)
    return np.asarray(eigh(wide @ wide.T, subset_by_index=(first, n_channels - 1))[1][:, ::-1])


def output_matrix(covariance: NDArray[np.float64], factors: HankelFactors) -> NDArray[np.float64]:
    """Return the output matrix of all channels, (n_channels, n_kept), for compressed factors."""
    n_columns = len(factors.right) // factors.n_references
    first_row = covariance[:n_columns].transpose(1, 0, 2).reshape(covariance.shape[1], -1)
    return np.asarray(first_row @ factors.columns)
