"""Modes of an arm at a pose, with its departures from the model."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
import scipy.linalg

from workspace_map.arm.arm_at_pose import ArmAtPose
from workspace_map.arm.state import State

Array = NDArray[np.float64]
LARGEST_LOG = 6.0
"""Of a factor on a spring, 400 times: beyond it a spring is as good as stiff or as gone."""
LEAST_LEFT = 0.1
"""Of mass, and of the springs' stiffness under gravity, that a search leaves in any direction."""


@dataclass(frozen=True)
class LocalModes:
    """Modes at one pose.

    Parameters
    ----------
    arm : ArmAtPose
        Where.
    n : int
        How many of the lowest are of interest.
    squared : (n_dof,) array [1/s²]
        ω², rising, of all modes.
    shapes : (n_dof, n_dof) array
        Mass-normalised, of all modes.
    damping, dampers : (n_dof, n_dof) array
        The damping matrix, and D with DᵀD what dampers have of it.
    energy : (n_dof, n_dof) array
        u = S W φ / ω, a column per mode: uᵀ (I + F) u ω²/2 is the strain energy of the springs.
    tension : (n_dof, n_dof) array
        (I + F) u.
    """

    arm: ArmAtPose
    n: int
    squared: Array
    shapes: Array
    damping: Array
    dampers: Array
    energy: Array
    tension: Array

    @property
    def frequency_hz(self) -> Array:
        """Natural frequencies, (n,) [Hz]."""
        return np.asarray(np.sqrt(self.squared[: self.n]) / (2.0 * np.pi))

    @property
    def damping_ratio(self) -> Array:
        """φᵀCφ/(2ω), (n,)."""
        shapes = self.shapes[:, : self.n]
        modal = np.sum(shapes * (self.damping @ shapes), axis=0)
        return np.asarray(modal / (2.0 * np.sqrt(self.squared[: self.n])))

    @property
    def channel_shapes(self) -> Array:
        """Mass-normalised shapes at the sensors, (n_channels, n)."""
        return np.asarray(self.arm.channels @ self.shapes[:, : self.n])

    @property
    def tool_shapes(self) -> Array:
        """Mass-normalised displacements of the tool point, (3, n) [kg^-1/2]."""
        return np.asarray(self.arm.tool[:3] @ self.shapes[:, : self.n])

    @property
    def residual(self) -> Array:
        """Static compliance at the tool point of the modes beyond the n lowest, (3, 3) [m/N]."""
        rest = self.arm.tool[:3] @ self.shapes[:, self.n :]
        return np.asarray((rest / self.squared[self.n :]) @ rest.T)


def local_modes(arm: ArmAtPose, state: State, highest_hz: float) -> LocalModes:
    """Solve K φ = ω² M φ with an arm's departures.

    Parameters
    ----------
    arm : ArmAtPose
        The model at the pose.
    state : State
        What the arm has and the model lacks.
    highest_hz : float [Hz]
        Modes below it are of interest.
    """
    springs = arm.spring_root * _factor(state.spring)[:, None]
    coupled = np.eye(len(springs)) + state.coupling_matrix
    stiffness = _positive(springs.T @ coupled @ springs, arm.other_stiffness)
    mass = _positive(arm.mass, np.tensordot(state.mass, arm.mass_changes, 1))
    dampers = arm.damper_root * _factor(state.damper)[:, None]
    damping = arm.mass_damping_1_s * mass + dampers.T @ dampers
    squared, shapes = scipy.linalg.eigh(stiffness, mass, driver='gvd', check_finite=False)
    energy = springs @ shapes / np.sqrt(squared)
    n = int(np.searchsorted(squared, (2.0 * np.pi * highest_hz) ** 2))
    return LocalModes(arm, n, squared, shapes, damping, dampers, energy, coupled @ energy)


def _factor(logarithm: Array) -> Array:
    return np.asarray(np.exp(0.5 * np.clip(logarithm, -LARGEST_LOG, LARGEST_LOG)))


def _positive(matrix: Array, change: Array) -> Array:
    """Return the changed matrix; as much of the change as leaves `LEAST_LEFT` everywhere."""
    if scipy.linalg.lapack.dpotrf((1.0 - LEAST_LEFT) * matrix + change)[1] == 0:
        return matrix + change
    lost = -float(scipy.linalg.eigvalsh(change, matrix, subset_by_index=(0, 0))[0])
    return np.asarray(matrix + change * min(1.0, (1.0 - LEAST_LEFT) / max(lost, 1e-300)))
