"""How poles of the poly-reference method answer to a small change of the spectra.

The coefficients a of the denominator solve M a = 0 but for the rows of A_0 = I, with
M = D - Cᵀ N⁻¹ C.  A change dM moves a root z, where A(z) v = 0 and wᵀ A(z) = 0, by

    dz = yᵀ dM u / wᵀ A'(z) v,    u = a v,    M y = (z^k w), k = 1 .. p, and y = 0 at k = 0,

and dM follows from dC and dD.  Their blocks are Toeplitz sequences, so the answer to every lag of
these is a correlation of u and y, and a whole solution for every change is not needed.

References
----------
Tisseur and Higham (2001), doi:10.1137/S0895479800371451 (first-order change of the roots of
matrix polynomials); Efron (1982), doi:10.1137/1.9781611970319, chapter 6 (the jackknife with the
derivative in place of estimates anew: infinitesimal jackknife).
"""

import numpy as np
from numpy.typing import NDArray

from oma_identifier.methods.polyreference import NormalEquations, OrderEquations

Complex = NDArray[np.complex128]


def pole_gradient(equations: NormalEquations, order: int, eigenvalue: Complex) -> Complex:
    """Return the derivatives of ln z with respect to the sums over the spectra.

    Parameters
    ----------
    equations : NormalEquations
        Of the spectra.
    order : int
        Polynomial order.
    eigenvalue : (n_poles,) complex array
        Roots z of that order.

    Returns
    -------
    (n_poles, n_values) complex array
        G with d ln z = G · :meth:`NormalEquations.change`.
    """
    solved = equations.of_order(order)
    left, right = _adjoint(solved, eigenvalue)
    seen = [np.einsum('pokr,mkr->mpo', solved.into_numerators, each) for each in (left, right)]
    reach, n_poles = 2 * equations.highest + 1, len(eigenvalue)
    cross = np.zeros((n_poles, reach, *equations.cross.shape[1:]), dtype=complex)
    denominator = np.zeros((n_poles, reach, *equations.denominator.shape[1:]), dtype=complex)
    for step in range(-order, order + 1):
        rows = slice(max(0, -step), order + 1 - max(0, step))
        columns = slice(rows.start + step, rows.stop + step)
        place = equations.highest + step
        denominator[:, place] = _products(left[:, rows], right[:, columns])
        cross[:, place] = _products(seen[1][:, rows], left[:, columns])
        cross[:, place] += _products(seen[0][:, rows], right[:, columns])
    return np.concatenate([cross.reshape(n_poles, -1), denominator.reshape(n_poles, -1)], axis=1)


def _adjoint(solved: OrderEquations, eigenvalue: Complex) -> tuple[Complex, Complex]:
    """Return y over z wᵀ A'(z) v, and u, (n_poles, order + 1, n_references) arrays."""
    coefficients = solved.coefficients
    size, r, _ = coefficients.shape
    powers = eigenvalue[:, None] ** np.arange(size)
    at_root = np.tensordot(powers, coefficients, axes=(1, 0))
    slope = np.tensordot(powers * np.arange(size), coefficients, axes=(1, 0))  # z A'(z)
    left_vectors, _, right_vectors = np.linalg.svd(at_root)
    w, v = left_vectors[:, :, -1].conj(), right_vectors[:, -1].conj()
    wanted = (powers[:, 1:, None] * w[:, None]).reshape(len(eigenvalue), -1)
    wanted /= np.einsum('mr,mrs,ms->m', w, slope, v)[:, None]
    left = np.zeros((len(eigenvalue), size * r), dtype=complex)
    left[:, r:] = np.linalg.solve(solved.reduced[r:, r:], wanted.T).T
    right = np.einsum('krs,ms->mkr', coefficients, v)
    return left.reshape(right.shape), right


def _products(one: Complex, other: Complex) -> Complex:
    """Return Σ_k one_k otherᵀ_k of each pole."""
    return np.asarray(one.transpose(0, 2, 1) @ other)
