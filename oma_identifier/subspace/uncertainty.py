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

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from oma_identifier.covariance import OutputCovariance
from oma_identifier.subspace.lag_gradient import LagGradient, times
from oma_identifier.subspace.ssi_cov import MultiOrder, OrderSolution
from oma_identifier.subspace.thresholds import SUBSPACE

TWO_SIGMA = 0.97724987
"""Normal probability below +2 standard deviations."""


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


class PoleSensitivity:
    """Sensitivities of the poles of all model orders to the covariances.

    Parameters
    ----------
    system : MultiOrder
        With all singular triplets.
    """

    def __init__(self, system: MultiOrder) -> None:
        factors = system.factors
        self._n_outputs = factors.n_outputs
        self._basis = system.observability
        self._orthogonal = system.orthogonal
        self._inverse = system.inverse
        self._to_lags = LagGradient(factors, system.highest)

    def gradients(
        self, solutions: Sequence[OrderSolution], eigenvalues: NDArray[np.complex128]
    ) -> NDArray[np.complex64]:
        """Return the derivatives of discrete-time poles with respect to the covariances.

        Parameters
        ----------
        solutions : sequence of OrderSolution
            Of the model order of each pole.
        eigenvalues : (n_poles,) complex array
            The poles of these orders nearest to them are taken.

        Returns
        -------
        (n_poles, n_lags, n_outputs, n_references) complex array
            G with dλ = Σ G ∘ dR.
        """
        orders = np.array([solution.order for solution in solutions])
        values, right, left = self._eigenvectors(solutions, eigenvalues)
        # dλ = a·dU φ + e·dU g, from the normal equations of A = U↑⁺ U↓
        half = times(self._inverse.T, left)
        half[np.arange(len(half))[:, None] >= orders] = 0.0
        g = times(self._inverse, half)
        weight = times(self._orthogonal, half)
        image = times(self._basis, right)
        rows = np.zeros((len(image), 2, len(orders)), dtype=complex)
        rows[self._n_outputs :, 0] = weight
        rows[: -self._n_outputs, 0] -= values * weight
        rows[: -self._n_outputs, 1] = image[self._n_outputs :] - values * image[: -self._n_outputs]
        return self._to_lags.of(rows, np.stack([right, g], axis=1), orders)

    def _eigenvectors(
        self, solutions: Sequence[OrderSolution], eigenvalues: NDArray[np.complex128]
    ) -> tuple[NDArray[np.complex128], ...]:
        """Return the eigenvalues, and their vectors with zeros up to the highest order."""
        values = np.empty(len(solutions), dtype=complex)
        right = np.zeros((len(self._inverse), len(solutions)), dtype=complex)
        left = np.zeros_like(right)
        together: dict[int, list[int]] = {}
        for number, solution in enumerate(solutions):
            together.setdefault(solution.order, []).append(number)
        for order, numbers in together.items():
            solution = solutions[numbers[0]]
            distance = np.abs(solution.eigenvalue - eigenvalues[numbers, None])
            nearest = np.argmin(distance, axis=1)
            values[numbers] = solution.eigenvalue[nearest]
            right[:order, numbers] = solution.vector[:, nearest]
            left[:order, numbers] = np.linalg.solve(solution.vector.T, np.eye(order)[:, nearest])
        return values, right, left


def influence(
    gradients: NDArray[np.complex64],
    eigenvalues: NDArray[np.complex128],
    covariance: OutputCovariance,
) -> NDArray[np.complex128]:
    """Return what each block of time does to each continuous-time pole.

    Parameters
    ----------
    gradients : (n_poles, n_lags, n_outputs, n_references) complex array
        From :meth:`PoleSensitivity.gradients`.
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
        Length of the record; infinite where the blocks are known to be independent.
    """
    size = abs(pole)
    d_size = (np.conj(pole) * series).real / size
    d_damping = -series.real / size + pole.real * d_size / size**2
    bandwidth_hz = max(-pole.real, 0.0) / (2.0 * np.pi)
    n_terms = int(min(2.0 * duration_s * bandwidth_hz, len(series)))
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
    n_terms = min(max(n_terms, SUBSPACE.fewest_terms), n_blocks - 1)
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
    return float(stdtrit(n_terms, TWO_SIGMA)) / 2.0
