"""One model at all lines, and the gradient of the Whittle likelihood of one band there.

Every derivative of the covariance E_k but those by noise and slope is w_k u_k v_kᴴ plus its
conjugate transpose, where u and v are columns of few matrices: no derivative is ever formed.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class Evaluated:
    """One model at all lines, as the derivatives need it.

    Parameters
    ----------
    count : (n_lines,) array
        Frequencies averaged in each line.
    amplitude : (n_lines, n_channels, n_modes) complex array
        A = Φ H.
    response : (n_lines, n_channels, n_free) complex array
        Columns of A S that belong to free modes.
    precision : (n_lines, n_channels, n_channels) complex array
        E⁻¹.
    residual : (n_lines, n_channels, n_channels) complex array
        E⁻¹ (P - E) E⁻¹.
    excess : (n_lines,) array
        tr(E⁻¹ P) - n_channels.
    gain, by_frequency, by_damping : (n_lines, n_free) complex array
        H of the free modes, its derivatives by ln f and ln ζ over H.
    colours : (2, n_lines) array
        Derivatives of ln(A S Aᴴ) by the slope of the force and by its curvature.
    noise : (n_channels,) array
        Noise power.
    across : (n_free, n_channels, n_channels - 1) complex array
        Directions across the shapes.
    root : (n_modes, n_forces) complex array or None
        Of the forces, where it has the parameters and not they.
    """

    count: Real
    amplitude: Complex
    response: Complex
    precision: Complex
    residual: Complex
    excess: Real
    gain: Complex
    by_frequency: Complex
    by_damping: Complex
    colours: Real
    noise: Real
    across: Complex
    root: Complex | None = None


@cache
def pairs(n_modes: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return rows and columns of the diagonal and upper triangle, row by row."""
    return np.triu_indices(n_modes)


def gradient(at: Evaluated) -> Real:
    """Return Σ n tr(E⁻¹ (P - E) E⁻¹ ∂E) for every parameter.

    Parameters of each free mode: ln f, ln ζ, then the shape along each direction across it (real
    and imaginary parts in turn); then the force (diagonal and upper triangle row by row, real
    parts, then the imaginary parts off the diagonal) or its root (row by row, real and imaginary
    parts in turn); then slope and curvature; then ln s of each channel.
    """
    weighted = at.count[:, None, None] * at.residual
    n_modes, n_free = at.amplitude.shape[2], at.response.shape[2]
    pulled = weighted @ at.response
    own = np.sum(pulled.conj() * at.amplitude[:, :, :n_free], axis=1)
    poles = 2.0 * np.stack(
        [np.sum(at.by_frequency * own, axis=0).real, np.sum(at.by_damping * own, axis=0).real]
    )
    turning = np.einsum('km,kcm->mc', at.gain, pulled.conj())
    turned = 2.0 * (turning[:, None] @ at.across)[:, 0]
    shapes = np.stack([turned.real, -turned.imag], axis=-1).reshape(n_free, -1)
    modes = np.concatenate([poles.T, shapes], axis=1).ravel()
    flat = at.amplitude.reshape(-1, n_modes)
    force = flat.conj().T @ (weighted @ at.amplitude).reshape(-1, n_modes)
    on_diagonal = np.einsum('kcc->kc', weighted).real * at.noise
    # A S Aᴴ = E - diag s
    trace = at.count * at.excess - on_diagonal.sum(axis=1)
    noise = on_diagonal.sum(axis=0)
    return np.concatenate(
        [
            modes,
            _by_force(force) if at.root is None else _by_root(force @ at.root),
            at.colours @ trace,
            noise,
        ]
    )


def _by_force(force: Complex) -> Real:
    first, second = pairs(len(force))
    off = first != second
    upper = force[first, second] * np.where(off, 2.0, 1.0)
    return np.concatenate([upper.real, upper[off].imag])


def _by_root(pulled: Complex) -> Real:
    return np.asarray(2.0 * np.stack([pulled.real, pulled.imag], axis=-1).ravel())
