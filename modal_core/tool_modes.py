"""Modes as the tool's point moves in them: what a map predicts and a stable cut needs."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
PER_MODE = 5
"""Parameters of a mode: log frequency, log damping ratio, and its shape along x, y and z."""


@dataclass(frozen=True, slots=True)
class ToolModes:
    """Normal modes at one point, mass-normalised.

    Parameters
    ----------
    frequency_hz : (n_modes,) array [Hz]
        Natural frequencies.
    damping_ratio : (n_modes,) array
    shape : (n_modes, 3) array [kg^-1/2]
        Displacement of the tool's point along x, y and z at unit modal mass; the mass felt along
        the shape is 1 / |shape|².
    covariance : (5 n_modes, 5 n_modes) array, or None
        Of ``parameters``; None where nobody knows it.
    """

    frequency_hz: Real
    damping_ratio: Real
    shape: Real
    covariance: Real | None = None

    @property
    def n_modes(self) -> int:
        """How many."""
        return len(self.frequency_hz)

    @property
    def parameters(self) -> Real:
        """Log frequency [ln Hz], log damping ratio and shape of mode after mode, (5 n_modes,)."""
        own = np.column_stack([np.log(self.frequency_hz), np.log(self.damping_ratio), self.shape])
        return np.asarray(own.ravel(), float)

    def with_parameters(self, parameters: Real) -> 'ToolModes':
        """Return the modes with other parameters, for instance of a sample or a small step."""
        own = np.asarray(parameters, float).reshape(-1, PER_MODE)
        return replace(
            self,
            frequency_hz=np.exp(own[:, 0]),
            damping_ratio=np.exp(own[:, 1]),
            shape=own[:, 2:].copy(),
        )

    def turned(self, axes: Real) -> 'ToolModes':
        """Return the modes in other axes.

        Parameters
        ----------
        axes : (3, 3) array
            Unit vectors of the new axes as rows, in the present ones.
        """
        turn = np.eye(PER_MODE)
        turn[2:, 2:] = axes
        every = np.kron(np.eye(self.n_modes), turn)
        known = None if self.covariance is None else every @ self.covariance @ every.T
        return replace(self, shape=self.shape @ np.asarray(axes).T, covariance=known)

    def receptance(self, frequency_hz: Real) -> Complex:
        """Return displacement over force at the tool's point, (n_lines, 3, 3) [m/N].

        Parameters
        ----------
        frequency_hz : (n_lines,) array [Hz]
            Where.
        """
        line = 2.0 * np.pi * np.asarray(frequency_hz, float)[:, None]
        own = 2.0 * np.pi * self.frequency_hz
        each = 1.0 / (own**2 - line**2 + 2j * self.damping_ratio * own * line)
        made: Complex = np.einsum('lm,mi,mj->lij', each, self.shape, self.shape)
        return made
