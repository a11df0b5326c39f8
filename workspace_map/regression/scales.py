"""How far the unknown functions are expected to depart, and over which angles they vary."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Scales:
    """Standard deviations and lengths of a prior; those that are 0 stay 0.

    Parameters
    ----------
    constant, varying : (n_parts,) array
        Of what is the same at all poses, and of what varies, per part of the unknown functions.
    white : (n_whites,) array
        Of what differs from row to row, per kind of row.
    length : (n_joints,) array [rad]
        Of each joint: over which the functions vary.
    """

    constant: Array
    varying: Array
    white: Array
    length: Array

    def logs(self) -> Array:
        """Return the logarithms of all that are not 0."""
        values = self._all()
        return np.log(values[values > 0.0])

    def with_logs(self, logs: Array) -> 'Scales':
        """Return scales with other logarithms of what is not 0."""
        values = self._all()
        values[values > 0.0] = np.exp(logs)
        ends = np.cumsum([len(self.constant), len(self.varying), len(self.white)])
        return Scales(*np.split(values, ends))

    def _all(self) -> Array:
        return np.concatenate([self.constant, self.varying, self.white, self.length])
