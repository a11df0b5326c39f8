"""What an arm has at a pose and its model lacks."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
# Couplings of springs are shares of their geometric mean; at 1 the stiffness is singular.
LARGEST_COUPLING = 0.9


@dataclass(frozen=True)
class State:
    """Departures of an arm from its model at one pose; all zero: the model itself.

    Parameters
    ----------
    spring : (n_dof,) array
        Logarithm of the factor on each spring.
    coupling : (n_dof (n_dof - 1) / 2,) array
        Between springs, upper triangle by rows, over the geometric mean of the two.
    mass : (n_masses,) array
        Times `ArmAtPose.mass_changes`: payload, then factors of links less 1.
    damper : (n_dof,) array
        Logarithm of the factor on each damper.
    """

    spring: Array
    coupling: Array
    mass: Array
    damper: Array

    @classmethod
    def none(cls, n_dof: int, n_masses: int) -> 'State':
        """Return no departure."""
        pairs = n_dof * (n_dof - 1) // 2
        return cls(np.zeros(n_dof), np.zeros(pairs), np.zeros(n_masses), np.zeros(n_dof))

    @property
    def coupling_matrix(self) -> Array:
        """Couplings as a symmetric matrix with a zero diagonal, kept positive definite."""
        size = len(self.spring)
        matrix = np.zeros((size, size))
        matrix[np.triu_indices(size, 1)] = self.coupling
        matrix += matrix.T
        largest = float(np.max(np.abs(np.linalg.eigvalsh(matrix)), initial=0.0))
        return matrix * min(1.0, LARGEST_COUPLING / max(largest, 1e-300))

    def towards(self, other: 'State', part: float) -> 'State':
        """Return a state part of the way to another."""
        return State(
            self.spring + part * (other.spring - self.spring),
            self.coupling + part * (other.coupling - self.coupling),
            self.mass + part * (other.mass - self.mass),
            self.damper + part * (other.damper - self.damper),
        )

    def without(self, payload: int) -> 'State':
        """Return it without the first numbers of ``mass``: those of a payload."""
        left = np.where(np.arange(len(self.mass)) < payload, 0.0, self.mass)
        return replace(self, mass=left)

    def plus(self, other: 'State') -> 'State':
        """Return both departures together."""
        return State(
            self.spring + other.spring,
            self.coupling + other.coupling,
            self.mass + other.mass,
            self.damper + other.damper,
        )
