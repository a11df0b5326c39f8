"""From one arm to another at a pose: forces on the old one that make it move as the new one."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_gap.cell import PoseArm

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Complex64 = NDArray[np.complex64]
Reals = NDArray[np.float32]


@dataclass(frozen=True)
class ArmChange:
    """From one arm to another at a pose.

    Parameters
    ----------
    matrix : (n_dof, 3 n_dof + 2 n_joints) array
        Force on the old arm per ``stacked`` motion.
    """

    matrix: Array

    @classmethod
    def between(cls, one: PoseArm, other: PoseArm) -> 'ArmChange':
        """Return the change from one arm to another."""
        parts = (
            one.M - other.M,
            one.C - other.C,
            one.K - other.K,
            other.inertia_input - one.inertia_input,
            other.shift_input - one.shift_input,
        )
        return cls(np.hstack(parts))


def stacked(
    omega: Array,
    deflection: Complex,
    acceleration: Complex,
    shift: Complex,
    end: tuple[Array, Array] | None = None,
) -> Complex64:
    """Return x'', x', x of the deflections and both inputs, one below the other.

    In single precision: differences lose nothing by it.  ``end`` is x and x' when the record ends,
    (n_dof,) each, by parts beside the spectra of x' and x''.  Without it masses, springs and
    dampers that all grow alike would seem to change the motion, by a percent of what each does:
    fits hardly moved along that line, and σ across it was too small.
    """
    end_shift, end_speed = (0.0, 0.0) if end is None else (part[:, None] for part in end)
    velocity = 1j * omega * deflection + end_shift
    motion = [1j * omega * velocity + end_speed, velocity, deflection, acceleration, shift]
    return np.concatenate(motion).astype(np.complex64)


def parts(motion: Complex64) -> Reals:
    """Return a motion (n, n_omega) as real and imaginary part at every frequency.

    (n_omega, 2, n): the matrices of a change are real.
    """
    return np.stack([motion.real.T, motion.imag.T], axis=1)


def forces(motion: Reals, changes: Sequence[ArmChange]) -> Complex64:
    """Return the forces on the old arm that changes are to first order.

    Parameters
    ----------
    motion : (n_omega, 2, 3 n_dof + 2 n_joints) array
        ``parts`` of a ``stacked`` one.
    changes : sequence of ArmChange
        At one pose.

    Returns
    -------
    (n_omega, n_dof, n_changes) complex array
    """
    matrices = np.array([change.matrix.T for change in changes], dtype=np.float32)
    moving = np.flatnonzero(matrices.any(axis=(0, 2)))
    count, _, n_dof = matrices.shape
    beside = matrices[:, moving].transpose(1, 2, 0).reshape(len(moving), n_dof * count)
    both = motion[:, :, moving].reshape(2 * len(motion), len(moving)) @ beside
    real, imaginary = both.reshape(len(motion), 2, n_dof, count).transpose(1, 0, 2, 3)
    found = np.empty(real.shape, dtype=np.complex64)
    found.real, found.imag = real, imaginary
    return found
