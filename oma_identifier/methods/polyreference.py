"""Poly-reference least squares in the frequency domain, all orders from one set of equations."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cholesky, eig, solve, solve_triangular

from oma_identifier.methods.half_spectra import half_spectra, HalfSpectra, LagSums
from oma_identifier.subspace import RawPoles


def plscf(
    rows: NDArray[np.float64],
    references: NDArray[np.int64],
    n_lags: int,
    orders: Sequence[int],
    band: tuple[float, float] = (0.0, 0.5),
) -> RawPoles:
    """Return the poles of all polynomial orders.

    The half spectra are fitted by B(z) A(z)⁻¹, polynomials in z = e^{iωΔt}; a polynomial order
    of p gives p poles per reference.

    Parameters
    ----------
    rows : (n_samples, n_channels) array
        Conditioned responses.
    references : (n_references,) int array
        Columns that serve as references.
    n_lags : int
        Longest lag of the half spectra.
    orders : sequence of int
        Polynomial orders.
    band : (2,) tuple
        Ends of the fitted band as fractions of the sample rate.

    Returns
    -------
    RawPoles
        ``model_order`` counts poles: polynomial order times references.

    References
    ----------
    Guillaume et al. (2003), IMAC XXI, A poly-reference implementation of the least-squares
    complex frequency-domain estimator; Peeters et al. (2004), doi:10.1155/2004/523692.
    """
    return poles_of_covariance(LagSums(rows, references, n_lags).covariance(), orders, band)


def poles_of_covariance(
    covariance: NDArray[np.float64], orders: Sequence[int], band: tuple[float, float]
) -> RawPoles:
    """Return the poles of all polynomial orders, see :func:`plscf`.

    Parameters
    ----------
    covariance : (n_lags + 1, n_channels, n_references) array
        Of the responses with the references.
    """
    spectra = half_spectra(covariance, *band)
    n_references = covariance.shape[2]
    equations = NormalEquations(spectra, orders[-1])
    order_of, eigenvalues, shapes = [], [], []
    for order in orders:
        found = equations.solve(order)
        order_of.append(np.full(len(found.eigenvalue), order * n_references))
        eigenvalues.append(found.eigenvalue * np.exp(spectra.decay))
        shapes.append(found.shape)
    return RawPoles(
        np.concatenate(order_of), np.concatenate(eigenvalues), np.concatenate(shapes, axis=1)
    )


class NormalEquations:
    """Reduced normal equations of all orders: those of a low order are a corner of the highest's.

    Parameters
    ----------
    spectra : HalfSpectra
        To be fitted.
    highest : int
        Highest polynomial order.
    weight : (n_lines,) array or None
        Of the squares of the lines; None: all alike.
    """

    def __init__(
        self, spectra: HalfSpectra, highest: int, weight: NDArray[np.float64] | None = None
    ) -> None:
        powers = np.arange(highest + 1)
        basis = np.exp(1j * spectra.angle[:, None] * powers)  # (n_lines, highest + 1)
        value = spectra.value
        _, n_channels, n_references = value.shape
        self.n_references, self.n_channels = n_references, n_channels
        # Every block is a Toeplitz sequence in the difference of two powers.
        steps = np.concatenate([basis[:, :0:-1].conj(), basis], axis=1)  # -highest .. highest
        if weight is not None:
            steps = steps * weight[:, None]
        auto = value.conj().transpose(0, 2, 1) @ value
        self._numerator = (steps.sum(axis=0)).real
        self._cross = -np.tensordot(steps, value, axes=(0, 0)).real
        self._denominator = np.tensordot(steps, auto, axes=(0, 0)).real
        self._highest = highest

    def solve(self, order: int) -> RawPoles:
        """Return the poles of one polynomial order; shapes are B(z_i) v_i with A(z_i) v_i = 0."""
        size, r = order + 1, self.n_references
        index = self._highest + np.arange(size) - np.arange(size)[:, None]
        numerator = self._numerator[index]
        numerator = numerator + 1e-12 * numerator[0, 0] * np.eye(size)
        factor = cholesky(numerator, lower=True, check_finite=False)
        cross = self._cross[index]  # (size, size, n_channels, r): row power, column power
        flat = cross.transpose(0, 2, 1, 3).reshape(size, -1)
        white = solve_triangular(factor, flat, lower=True, check_finite=False)
        stacked = white.reshape(size * self.n_channels, size * r)
        reduced = self._denominator[index].transpose(0, 2, 1, 3).reshape(size * r, size * r)
        reduced = reduced - stacked.T @ stacked
        # A_0 = I: with the lowest coefficient fixed, spurious poles come out unstable.
        # A pure line makes the equations nearly singular, which is no reason to warn.
        rest = np.linalg.solve(reduced[r:, r:], -reduced[r:, :r])
        coefficients = np.concatenate([np.eye(r), rest]).reshape(size, r, r)
        eigenvalue, vector = _roots(coefficients)
        numerators = -np.tensordot(
            solve(numerator, flat, assume_a='pos', check_finite=False).reshape(
                size, self.n_channels, size, r
            ),
            coefficients,
            axes=([2, 3], [0, 1]),
        )
        upper = (eigenvalue.imag > 0.0) & np.isfinite(eigenvalue)
        eigenvalue, vector = eigenvalue[upper], vector[:, upper]
        powers = eigenvalue[None] ** np.arange(size)[:, None]
        shape = np.einsum('pm,pos,sm->om', powers, numerators, vector, optimize=True)
        return RawPoles(np.full(len(eigenvalue), order * r), eigenvalue, shape)


def _roots(
    coefficients: NDArray[np.float64],
) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Return the roots z of det Σ A_p z^p = 0 and vectors v with A(z) v = 0."""
    size, r, _ = coefficients.shape
    order = size - 1
    # Reversed polynomial in 1/z has the leading coefficient A_0 = I.
    companion = np.zeros((order * r, order * r))
    companion[:r] = -np.concatenate(list(coefficients[1:]), axis=1)
    companion[r:, :-r] = np.eye((order - 1) * r)
    inverse, vectors = eig(companion, check_finite=False)
    with np.errstate(divide='ignore', invalid='ignore'):
        return np.asarray(1.0 / inverse), np.asarray(vectors[:r], dtype=complex)
