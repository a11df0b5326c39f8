"""Modes at a pose that was never measured, with their covariance."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PredictedModes:
    """Modes expected at one pose and the response of the tool point that they make.

    Parameters
    ----------
    q : (n_joints,) array [rad]
        Serial joint angles.
    frequency_hz, damping_ratio : (n_modes,) array [Hz], [-]
        Rising frequency.
    tool_shapes : (3, n_modes) array [kg^-1/2]
        Mass-normalised displacement of the tool point along the tool's axes.
    channel_shapes : (n_channels, n_modes) array [kg^-1/2]
        The same at the sensors.
    covariance : (5 n_modes, 5 n_modes) array
        Of log f of all modes, log ζ of all modes, then x, y, z of the first mode's tool shape, of
        the second's, ...
    residual : (3, 3) array [m/N]
        Static compliance of the tool point by modes beyond these.
    """

    q: Array
    frequency_hz: Array
    damping_ratio: Array
    tool_shapes: Array
    channel_shapes: Array
    covariance: Array
    residual: Array

    def __len__(self) -> int:
        """Return the number of modes."""
        return len(self.frequency_hz)

    @property
    def frequency_std_hz(self) -> Array:
        """Standard deviations, (n_modes,) [Hz]."""
        return np.asarray(self.frequency_hz * self._stds(0))

    @property
    def damping_ratio_std(self) -> Array:
        """Standard deviations, (n_modes,)."""
        return np.asarray(self.damping_ratio * self._stds(1))

    @property
    def tool_shape_std(self) -> Array:
        """Standard deviations of ``tool_shapes``, (3, n_modes)."""
        n = len(self)
        return np.asarray(np.sqrt(np.diag(self.covariance)[2 * n :]).reshape(n, 3).T)

    @property
    def modal_mass_kg(self) -> Array:
        """Mass of each mode when its displacement of the tool point has length 1, (n_modes,)."""
        return np.asarray(1.0 / np.sum(self.tool_shapes**2, axis=0))

    @property
    def modal_mass_std_kg(self) -> Array:
        """Standard deviations of `modal_mass_kg`: of 1/φ², to first order, (n_modes,)."""
        n = len(self)
        blocks = self.covariance[2 * n :, 2 * n :].reshape(n, 3, n, 3)
        own = blocks[np.arange(n), :, np.arange(n), :]
        along = np.einsum('am,mab,bm->m', self.tool_shapes, own, self.tool_shapes)
        return np.asarray(2.0 * self.modal_mass_kg**2 * np.sqrt(along))

    def draws(self, count: int, seed: int = 0) -> 'list[PredictedModes]':
        """Return modes as they may be: draws from their distribution."""
        n, generator = len(self), np.random.default_rng(seed)
        off = generator.multivariate_normal(
            np.zeros(5 * n), self.covariance, count, check_valid='ignore', method='eigh'
        )
        return [
            PredictedModes(
                self.q,
                self.frequency_hz * np.exp(row[:n]),
                self.damping_ratio * np.exp(row[n : 2 * n]),
                self.tool_shapes + row[2 * n :].reshape(n, 3).T,
                self.channel_shapes,
                self.covariance,
                self.residual,
            )
            for row in off
        ]

    def _stds(self, block: int) -> Array:
        n = len(self)
        return np.asarray(np.sqrt(np.diag(self.covariance)[block * n : (block + 1) * n]))
