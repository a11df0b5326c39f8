"""Standard deviations of poles from the scatter of the output covariances, by adjoints.

The first-order perturbation theory of Döhler and Mevel gives the change of an eigenvalue for any
change of the block Hankel matrix.  Read backwards (adjoint), one matrix per pole says how the
pole answers to every covariance.  Its inner product with the covariances of each block of time is
a scalar series, and the long-run variance of that series is the variance of the pole: no
covariance matrix of covariances and no Kronecker product is ever formed.

References
----------
Döhler and Mevel (2013), doi:10.1016/j.ymssp.2012.11.011, Eq. (22)-(37);
Lazarus, Lewis, Stock and Watson (2018), doi:10.1080/07350015.2018.1506926 (cosine estimator of
the long-run variance with exact t critical values).
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.stats import t as student_t

from oma_identifier.output_covariance import OutputCovariance
from oma_identifier.ssi_cov import HankelFactors, MultiOrder, OrderSolution

TWO_SIGMA = 0.97724987
"""Normal probability below +2 standard deviations."""
FEWEST_TERMS = 6


@dataclass(frozen=True, slots=True)
class PoleDeviation:
    """Standard deviations of one pole.

    Parameters
    ----------
    frequency_std_hz : float [Hz]
        Of the natural frequency.
    damping_ratio_std : float
        Of the damping ratio.
    """

    frequency_std_hz: float
    damping_ratio_std: float


class OrderSensitivity:
    """Sensitivities of the poles of one model order to the covariances.

    Parameters
    ----------
    system : MultiOrder
        With all singular triplets.
    solution : OrderSolution
        Of the model order.
    """

    def __init__(self, system: MultiOrder, solution: OrderSolution) -> None:
        order, size = solution.order, system.factors.n_outputs
        basis = system.factors.left[:, :order]
        self._factors = system.factors
        self._upper, self._lower = basis[:-size], basis[size:]
        self._orthogonal = system.orthogonal[:, :order]
        self._triangle = system.triangle[:order, :order]
        self._solution = solution
        self._left_vectors = np.linalg.inv(solution.vector)

    def gradient(self, eigenvalue: complex) -> NDArray[np.complex128]:
        """Return the derivative of a discrete-time pole with respect to the covariances.

        Parameters
        ----------
        eigenvalue : complex
            The pole of this order nearest to it is taken.

        Returns
        -------
        (n_lags, n_outputs, n_references) complex array
            G with dλ = Σ G ∘ dR.
        """
        factors, triangle = self._factors, self._triangle
        nearest = int(np.argmin(np.abs(self._solution.eigenvalue - eigenvalue)))
        value = self._solution.eigenvalue[nearest]
        vector = self._solution.vector[:, nearest]
        # dλ = a·dU φ + e·dU g, from the normal equations of A = U↑⁺ U↓
        half = solve_triangular(triangle, self._left_vectors[nearest], trans='T')
        weight = self._orthogonal @ half
        zeros = np.zeros(factors.n_outputs)
        a = np.concatenate([zeros, weight]) - value * np.concatenate([weight, zeros])
        residual = np.concatenate([self._lower @ vector - value * (self._upper @ vector), zeros])
        g = solve_triangular(triangle, half)
        hankel = _through_singular_vectors(
            factors, np.column_stack([a, residual]), np.column_stack([vector, g])
        )
        return _sum_over_lags(hankel, factors.n_outputs, factors.n_references)


def _through_singular_vectors(
    factors: HankelFactors, rows: NDArray[np.complex128], columns: NDArray[np.complex128]
) -> NDArray[np.complex128]:
    """Carry a gradient ``rows @ columns.T`` on the leading left singular vectors over to H.

    A change of H turns the leading vectors only towards the others:
    u_jᵀ du_k = (s_k u_jᵀ dH v_k + s_j u_kᵀ dH v_j) / (s_k² - s_j²).
    """
    order = len(columns)
    kept, rest = slice(0, order), slice(order, None)
    left, right, values = factors.left, factors.right, factors.values
    projected = left.T @ rows
    outside = rows - left @ projected
    gap = values[kept] ** 2 - values[rest, None] ** 2
    mixed = (projected[rest] @ columns.T) / gap
    low_rank = outside @ (columns / values[kept, None]).T
    # A standard deviation needs no more than single precision: half the time.
    left32, right32 = factors.single_left, factors.single_right
    outer_right = np.empty((2 * order, len(right)), dtype=np.float32)
    outer_right[:order] = right32[:, kept].T
    outer_left = np.empty((len(left), 2 * order), dtype=np.float32)
    outer_left[:, order:] = left32[:, kept]
    parts = []
    # Real and imaginary part apart: complex times real products would double the work.
    for mix, extra in ((mixed.real, low_rank.real), (mixed.imag, low_rank.imag)):
        into_left = (mix * values[kept]).astype(np.float32)
        into_right = (mix * values[rest, None]).astype(np.float32)
        outer_left[:, :order] = left32[:, rest] @ into_left + extra
        outer_right[order:] = (right32[:, rest] @ into_right).T
        parts.append(outer_left @ outer_right)
    return np.asarray(parts[0] + 1j * parts[1])


def _sum_over_lags(
    hankel_gradient: NDArray[np.complex128], n_channels: int, n_references: int
) -> NDArray[np.complex128]:
    """Sum a gradient over equal lags: (n_lags, n_channels, n_references) complex array."""
    rows, columns = hankel_gradient.shape
    block_rows, block_columns = rows // n_channels, columns // n_references
    blocks = hankel_gradient.reshape(block_rows, n_channels, block_columns, n_references)
    gradient = np.zeros(
        (block_rows + block_columns - 1, n_channels, n_references), dtype=np.complex64
    )
    for row in range(block_rows):
        gradient[row : row + block_columns] += blocks[row].transpose(1, 0, 2)
    return gradient


def influence(
    gradients: NDArray[np.complex128],
    eigenvalues: NDArray[np.complex128],
    covariance: OutputCovariance,
) -> NDArray[np.complex128]:
    """Return what each block of time does to each continuous-time pole.

    Parameters
    ----------
    gradients : (n_poles, n_lags, n_outputs, n_references) complex array
        From :meth:`OrderSensitivity.gradient`.
    eigenvalues : (n_poles,) complex array
        Discrete-time poles.
    covariance : OutputCovariance
        The covariances the poles come from, in blocks.

    Returns
    -------
    (n_blocks, n_poles) complex array [rad/s]
        Its mean over the blocks is the first-order error of the pole.
    """
    flat = gradients.reshape(len(gradients), -1)
    blocks = covariance.single_blocks
    change = np.asarray(blocks @ flat.real.T + 1j * (blocks @ flat.imag.T), dtype=complex)
    change -= change.mean(axis=0)
    return np.asarray(change * covariance.sample_rate_hz / eigenvalues)


def deviation_from(
    series: NDArray[np.complex128], pole: complex, duration_s: float
) -> PoleDeviation:
    """Return the standard deviations of frequency and damping.

    Parameters
    ----------
    series : (n_blocks,) complex array [rad/s]
        Influence of each block on the pole.
    pole : complex [rad/s]
        Continuous-time pole.
    duration_s : float [s]
        Length of the record.
    """
    size = abs(pole)
    d_size = (np.conj(pole) * series).real / size
    d_damping = -series.real / size + pole.real * d_size / size**2
    bandwidth_hz = max(-pole.real, 0.0) / (2.0 * np.pi)
    n_terms = int(2.0 * duration_s * bandwidth_hz)
    return PoleDeviation(
        frequency_std_hz=deviation_of_mean(d_size / (2.0 * np.pi), n_terms),
        damping_ratio_std=deviation_of_mean(d_damping, n_terms),
    )


def deviation_of_mean(series: NDArray[np.float64], n_terms: int) -> float:
    """Return the standard deviation of the mean of a correlated series.

    Parameters
    ----------
    series : (n_blocks,) array
        One value per block of time.
    n_terms : int
        Cosine terms that lie in the flat low-frequency part of the series' spectrum.

    Returns
    -------
    float
        Widened by Student's t for the terms used, so that ±2 of it covers 95.4 %.
    """
    n_blocks = len(series)
    n_terms = min(max(n_terms, FEWEST_TERMS), n_blocks - 1)
    if n_terms < 2:
        return float('nan')
    terms = _cosines(n_terms, n_blocks) @ series
    return float(_widening(n_terms) * np.sqrt(np.mean(terms**2) / n_blocks))


@lru_cache(maxsize=256)
def _cosines(n_terms: int, n_blocks: int) -> NDArray[np.float64]:
    """Return the first cosine terms of unit length, (n_terms, n_blocks)."""
    phase = np.pi * np.outer(np.arange(1, n_terms + 1), np.arange(n_blocks) + 0.5) / n_blocks
    return np.asarray(np.sqrt(2.0 / n_blocks) * np.cos(phase))


@lru_cache(maxsize=256)
def _widening(n_terms: int) -> float:
    """Return Student's t over the normal quantile at two standard deviations."""
    return float(student_t.ppf(TWO_SIGMA, n_terms)) / 2.0
