"""Mass, damping and stiffness at a pose, and the modes they have."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
import scipy.linalg

from modal_core.errors import ModelError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class StructuralMatrices:
    """M x'' + C x' + K x = f at one pose.

    Parameters
    ----------
    M, C, K : (n_dof, n_dof) array
        Mass, damping and stiffness; M and K symmetric positive definite.
    dof_names : tuple of str
        Rows.
    """

    M: Array
    C: Array
    K: Array
    dof_names: tuple[str, ...]


@dataclass(frozen=True)
class ModelModes:
    """Undamped modes with the damping each has in the model.

    Parameters
    ----------
    frequency_hz : (n_modes,) array [Hz]
        Natural frequencies, rising.
    damping_ratio : (n_modes,) array
        φᵀCφ/(2ω): exact when the damping is proportional, to first order otherwise.
    shapes : (n_dof, n_modes) array
        Mass-normalised: φᵀMφ = 1.
    channel_shapes : (n_channels, n_modes) array
        The same at the channels.
    """

    frequency_hz: Array
    damping_ratio: Array
    shapes: Array
    channel_shapes: Array


@dataclass(frozen=True)
class DampedModes:
    """Poles and complex modes of the damped arm: what a measurement ought to find.

    Parameters
    ----------
    poles_1_s : (n_modes,) complex array [1/s]
        One of each conjugate pair, imaginary part positive.
    frequency_hz : (n_modes,) array [Hz]
        |λ|/2π, rising.
    damping_ratio : (n_modes,) array
        -Re λ/|λ|.
    shapes : (n_dof, n_modes) complex array
        Displacement part, φᵀ(2λM + C)φ = 1.
    channel_shapes : (n_channels, n_modes) complex array
        The same at the channels.
    """

    poles_1_s: NDArray[np.complex128]
    frequency_hz: Array
    damping_ratio: Array
    shapes: NDArray[np.complex128]
    channel_shapes: NDArray[np.complex128]


def undamped_modes(matrices: StructuralMatrices, jacobian: Array) -> ModelModes:
    """Solve K φ = ω² M φ.

    Parameters
    ----------
    matrices : StructuralMatrices
        At one pose.
    jacobian : (n_channels, n_dof) array
        Channels over degrees of freedom.

    Raises
    ------
    ModelError
        M or K is not positive definite.
    """
    # A rigid arm has nothing to solve, which scipy before 1.14 refuses.
    squared, shapes = np.zeros(0), np.zeros_like(matrices.M)
    try:
        if shapes.size:
            squared, shapes = scipy.linalg.eigh(
                matrices.K, matrices.M, driver='gvd', check_finite=False
            )
    except np.linalg.LinAlgError as error:
        raise ModelError('mass matrix is not positive definite') from error
    if np.any(squared <= 0.0):
        raise ModelError(
            'stiffness matrix is not positive definite', found=f'ω² = {squared[0]:.4g} 1/s²'
        )
    omega = np.sqrt(squared)
    modal_damping = np.einsum('im,ij,jm->m', shapes, matrices.C, shapes, optimize=True)
    return ModelModes(
        frequency_hz=omega / (2.0 * np.pi),
        damping_ratio=modal_damping / (2.0 * omega),
        shapes=shapes,
        channel_shapes=jacobian @ shapes,
    )


def damped_modes(matrices: StructuralMatrices, jacobian: Array) -> DampedModes:
    """Solve (λ²M + λC + K) φ = 0 without assuming proportional damping.

    Parameters
    ----------
    matrices : StructuralMatrices
        At one pose.
    jacobian : (n_channels, n_dof) array
        Channels over degrees of freedom.

    Notes
    -----
    Overdamped degrees of freedom have real poles and are left out.
    """
    size = len(matrices.M)
    solved = np.hstack([matrices.K, matrices.C])
    if size:  # nothing of a rigid arm
        solved = scipy.linalg.cho_solve(scipy.linalg.cho_factor(matrices.M), solved)
    first_order = np.zeros((2 * size, 2 * size))
    first_order[:size, size:] = np.eye(size)
    first_order[size:] = -solved
    poles, vectors = np.linalg.eig(first_order)
    keep = np.flatnonzero(poles.imag > 1e-9 * np.abs(poles))
    keep = keep[np.argsort(np.abs(poles[keep]))]
    poles, shapes = poles[keep], vectors[:size, keep]
    scale = np.einsum('im,ij,jm->m', shapes, matrices.C, shapes) + 2.0 * poles * np.einsum(
        'im,ij,jm->m', shapes, matrices.M, shapes
    )
    shapes = shapes / np.sqrt(scale)
    return DampedModes(
        poles_1_s=poles,
        frequency_hz=np.abs(poles) / (2.0 * np.pi),
        damping_ratio=-poles.real / np.abs(poles),
        shapes=shapes,
        channel_shapes=jacobian @ shapes,
    )
