"""Controller axis angles and serial joint angles: the one place that knows the parallel rod.

On arms with a parallel rod the controller's axis 3 is the inclination of the upper arm, so that
the serial joint is j₃ = J₃ - J₂.  In general J = T j with a unit triangular T.  Drives and
their springs act on controller axes: a rod that holds the upper arm's inclination resists the sum
of both twists.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from modal_core.errors import ModelError


@dataclass(frozen=True, slots=True)
class AxisCoupling:
    """Controller axis ``axis`` reads serial joint ``axis`` plus ``factor`` times ``added``.

    Parameters
    ----------
    axis, added : str
        Joint names.
    factor : float
        1 for a parallel rod.
    """

    axis: str
    added: str
    factor: float = 1.0


@dataclass(frozen=True)
class AxisMap:
    """The linear map J = T j between serial joints and controller axes.

    Parameters
    ----------
    matrix : (n_joints, n_joints) array
        T; controller angles per serial angle.
    """

    matrix: NDArray[np.float64]

    @classmethod
    def build(cls, joint_names: Sequence[str], couplings: Sequence[AxisCoupling]) -> 'AxisMap':
        """Build T from the couplings.

        Raises
        ------
        ModelError
            A coupling names an unknown joint or cannot be inverted.
        """
        matrix = np.eye(len(joint_names))
        names = list(joint_names)
        for coupling in couplings:
            for name in (coupling.axis, coupling.added):
                if name not in names:
                    raise ModelError(
                        'coupling names an unknown joint', found=name, expected=', '.join(names)
                    )
            matrix[names.index(coupling.axis), names.index(coupling.added)] += coupling.factor
        if abs(np.linalg.det(matrix)) < 1e-9:
            raise ModelError('axis coupling cannot be inverted', found=matrix.tolist())
        return cls(matrix)

    def to_controller(self, serial: ArrayLike) -> NDArray[np.float64]:
        """Return controller angles (rates, accelerations) of serial ones, (..., n_joints)."""
        return np.asarray(np.asarray(serial, dtype=float) @ self.matrix.T)

    def to_serial(self, controller: ArrayLike) -> NDArray[np.float64]:
        """Return serial angles (rates, accelerations) of controller ones, (..., n_joints)."""
        return np.asarray(np.asarray(controller, dtype=float) @ np.linalg.inv(self.matrix).T)

    def torque_to_controller(self, serial: ArrayLike) -> NDArray[np.float64]:
        """Return the drive torques T⁻ᵀτ that hold serial joint torques τ, (..., n_joints)."""
        return np.asarray(np.asarray(serial, dtype=float) @ np.linalg.inv(self.matrix))
