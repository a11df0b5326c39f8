"""Poly-reference least squares in the frequency domain, all orders from one set of equations."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cholesky, eig, solve_triangular

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
    spectra = half_spectra(LagSums(rows, references, n_lags).covariance(), *band)
    return poles_of(NormalEquations(spectra, orders[-1]), orders, spectra.decay)


def poles_of(equations: 'NormalEquations', orders: Sequence[int], decay: float) -> RawPoles:
    """Return the poles of all polynomial orders, see :func:`plscf`.

    Parameters
    ----------
    equations : NormalEquations
        Of the highest order or above.
    orders : sequence of int
        Polynomial orders.
    decay : float
        Of the exponential window, per lag.
    """
    found = [equations.solve(order) for order in orders]
    return RawPoles(
        np.concatenate([each.model_order for each in found]),
        np.concatenate([each.eigenvalue for each in found]) * np.exp(decay),
        np.concatenate([each.shape for each in found], axis=1),
    )


@dataclass(frozen=True, slots=True)
class OrderEquations:
    """The equations of one polynomial order p and what solves them.

    Parameters
    ----------
    coefficients : (p + 1, n_references, n_references) array
        A_0 .. A_p.
    into_numerators : (p + 1, n_channels, p + 1, n_references) array
        From coefficients of the denominator to those of the numerators.
    reduced : ((p + 1) n_references, (p + 1) n_references) array
        What the coefficients of the denominator make least.
    """

    coefficients: NDArray[np.float64]
    into_numerators: NDArray[np.float64]
    reduced: NDArray[np.float64]


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
        self._value = spectra.value
        _, self.n_channels, self.n_references = spectra.value.shape
        # Every block is a Toeplitz sequence in the difference of two powers.
        steps = np.concatenate([basis[:, :0:-1].conj(), basis], axis=1)  # -highest .. highest
        self._steps = steps if weight is None else steps * weight[:, None]
        self._numerator = self._steps.sum(axis=0).real
        self.cross = self._sums(-self._value)
        self.denominator = self._sums(_adjoint(self._value) @ self._value)
        self.highest = highest

    def change(self, value: NDArray[np.complex128]) -> NDArray[np.float64]:
        """Return how ``cross`` and ``denominator`` change with the spectra, to first order.

        Parameters
        ----------
        value : (n_lines, n_channels, n_references) complex array
            Spectra that are near by.

        Returns
        -------
        (n_values,) array
            Both in a row.
        """
        off = value - self._value
        both = _adjoint(self._value) @ off
        sums = self._sums(-off), self._sums(both + _adjoint(both))
        return np.concatenate([each.ravel() for each in sums])

    def _sums(self, value: NDArray[np.complex128]) -> NDArray[np.float64]:
        return np.asarray(np.tensordot(self._steps, value, axes=(0, 0)).real)

    def of_order(self, order: int) -> 'OrderEquations':
        """Solve for the polynomials of one order."""
        size, r = order + 1, self.n_references
        index = self.highest + np.arange(size) - np.arange(size)[:, None]
        numerator = self._numerator[index]
        numerator = numerator + 1e-12 * numerator[0, 0] * np.eye(size)
        factor = cholesky(numerator, lower=True, check_finite=False)
        cross = self.cross[index]  # (size, size, n_channels, r): row power, column power
        flat = cross.transpose(0, 2, 1, 3).reshape(size, -1)
        white = solve_triangular(factor, flat, lower=True, check_finite=False)
        stacked = white.reshape(size * self.n_channels, size * r)
        reduced = self.denominator[index].transpose(0, 2, 1, 3).reshape(size * r, size * r)
        reduced = reduced - stacked.T @ stacked
        # A_0 = I: with the lowest coefficient fixed, spurious poles come out unstable.
        # A pure line makes the equations nearly singular, which is no reason to warn.
        rest = np.linalg.solve(reduced[r:, r:], -reduced[r:, :r])
        coefficients = np.concatenate([np.eye(r), rest]).reshape(size, r, r)
        white = solve_triangular(factor, white, lower=True, trans='T', check_finite=False)
        into_numerators = -white.reshape(size, self.n_channels, size, r)
        return OrderEquations(coefficients, into_numerators, reduced)

    def solve(self, order: int) -> RawPoles:
        """Return the poles of one polynomial order; shapes are B(z_i) v_i with A(z_i) v_i = 0."""
        solved = self.of_order(order)
        numerators = np.tensordot(
            solved.into_numerators, solved.coefficients, axes=([2, 3], [0, 1])
        )
        eigenvalue, vector = _roots(solved.coefficients)
        upper = (eigenvalue.imag > 0.0) & np.isfinite(eigenvalue)
        eigenvalue, vector = eigenvalue[upper], vector[:, upper]
        powers = eigenvalue[None] ** np.arange(order + 1)[:, None]
        shape = np.einsum('pm,pos,sm->om', powers, numerators, vector, optimize=True)
        return RawPoles(np.full(len(eigenvalue), order * self.n_references), eigenvalue, shape)


def _adjoint(values: NDArray[np.complex128]) -> NDArray[np.complex128]:
    return np.asarray(values.conj().transpose(0, 2, 1))


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
