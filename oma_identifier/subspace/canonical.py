"""Subspace identification by canonical variates: past and future made white first.

The singular values of a block Hankel matrix are powers, so that strong modes come first and weak
ones between them drown in the scatter of the strong.  Those of L⁻¹ H K⁻ᵀ, with L Lᵀ the covariance
of the future with itself and K Kᵀ that of the past, are correlations: a mode counts by how far it
is foreseen.  Where modes overlap it tells them apart at orders where the plain factorisation mixes
them; it needs more data, and takes a mode that drifts for several.

References
----------
Larimore (1983), Proc. American Control Conference, 445-451 (canonical variate analysis);
Van Overschee and De Moor (1996), Subspace Identification for Linear Systems, Kluwer, section 3.3.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from oma_identifier.subspace.ssi_cov import block_hankel, HankelFactors, singular_triplets
from oma_identifier.subspace.ssi_data import triangular_factor
from oma_identifier.subspace.thresholds import SUBSPACE

Real = NDArray[np.float64]


def factorise_canonical(covariance: Real, at_once: Real, block_rows: int) -> HankelFactors:
    """Return the singular triplets of the block Hankel matrix of white past and future.

    Parameters
    ----------
    covariance : (n_lags, n, n) array
        Of channels with themselves, R_1 .. R_n_lags.
    at_once : (n, n) array
        R_0.
    block_rows : int
        Block rows; n_lags + 1 - block_rows block columns follow.
    """
    hankel, n_channels = block_hankel(covariance, block_rows), len(at_once)
    lags = np.concatenate([at_once[None], covariance])
    future = _root(lags[:block_rows])
    past = _root(lags[: hankel.shape[1] // n_channels].transpose(0, 2, 1))
    white = solve_triangular(future, hankel, lower=True, check_finite=False)
    white = solve_triangular(past, white.T, lower=True, check_finite=False).T
    left, values, right = singular_triplets(white)
    return HankelFactors(left, values, right, n_channels, n_channels, future, past)


def _root(lags: Real) -> Real:
    """Return the Cholesky factor of the block Toeplitz matrix with R_{p-q} in block (p, q)."""
    count, size = len(lags), lags.shape[1]
    first, second = np.indices((count, count))
    blocks = lags[np.abs(first - second)]
    below = first < second
    blocks[below] = blocks[below].transpose(0, 2, 1)
    matrix = blocks.transpose(0, 2, 1, 3).reshape(count * size, -1)
    values, vectors = np.linalg.eigh(0.5 * (matrix + matrix.T))
    # Filters leave next to nothing near the ends of a band, and sums are of single precision.
    gram = (vectors * np.maximum(values, 0.0)) @ vectors.T
    return triangular_factor(gram, SUBSPACE.least_white)
