"""Poles over the model order: what a stabilisation diagram shows."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray


class PoleStatus(IntEnum):
    """Why a pole was kept or rejected; the numbers of oma_msgs/StabilisationDiagram."""

    KEPT = 0
    UNSTABLE_POLE = 1
    OVERDAMPED = 2
    OUT_OF_BAND = 3
    FREQUENCY_NOT_STABLE = 4
    DAMPING_NOT_STABLE = 5
    SHAPE_NOT_STABLE = 6
    UNCERTAIN = 7
    COMPLEX_SHAPE = 8
    SMALL_CLUSTER = 9
    HARMONIC = 10
    CLUSTER_OUTLIER = 11
    WEAK = 12


@dataclass(frozen=True, slots=True)
class PoleTable:
    """Poles of all model orders, one row each.

    Parameters
    ----------
    model_order : (n_poles,) int array
        State-space order the pole was found at.
    pole : (n_poles,) complex array [rad/s]
        Continuous-time pole s, upper half plane.
    shape : (n_channels, n_poles) complex array
        Mode shapes as columns.
    status : (n_poles,) uint8 array
        A :class:`PoleStatus` each.
    mode_id : (n_poles,) int array
        Mode the pole belongs to, 0 for none.
    """

    model_order: NDArray[np.int64]
    pole: NDArray[np.complex128]
    shape: NDArray[np.complex128]
    status: NDArray[np.uint8]
    mode_id: NDArray[np.int64]

    @property
    def frequency_hz(self) -> NDArray[np.float64]:
        """Undamped natural frequencies |s| / 2π [Hz]."""
        return np.abs(self.pole) / (2.0 * np.pi)

    @property
    def damping_ratio(self) -> NDArray[np.float64]:
        """Damping ratios -Re(s) / |s|."""
        return -self.pole.real / np.abs(self.pole)

    def chosen(self, which: NDArray[np.bool_]) -> 'PoleTable':
        """Return some of the poles."""
        return PoleTable(
            self.model_order[which],
            self.pole[which],
            self.shape[:, which],
            self.status[which],
            self.mode_id[which],
        )

    def joined(self, other: 'PoleTable') -> 'PoleTable':
        """Return these poles and those of another table after them."""
        return PoleTable(
            np.concatenate([self.model_order, other.model_order]),
            np.concatenate([self.pole, other.pole]),
            np.concatenate([self.shape, other.shape], axis=1),
            np.concatenate([self.status, other.status]),
            np.concatenate([self.mode_id, other.mode_id]),
        )

    def __len__(self) -> int:
        """Return the number of poles."""
        return len(self.pole)
