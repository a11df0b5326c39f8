"""What gears do beyond springs and dampers: friction, backlash, hardening."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dgesv

from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]
N_AXES = 6
NONE = (0.0,) * N_AXES
SUBSTEPS = 2
MOST_ITERATIONS = 12
TORQUE_TOLERANCE_NM = 1e-4
EYE = np.eye(N_AXES)


@dataclass(frozen=True, slots=True)
class GearSettings:
    """Nonlinear torques of each drive, on controller axes; zeros are a linear arm.

    Parameters
    ----------
    friction_nm : (6,) tuple [N m]
        Coulomb friction against the rate of the deflection.
    friction_speed_rad_s : float [rad/s]
        Rate at which friction is developed.
    backlash_rad : (6,) tuple [rad]
        Half of the free play.
    hardening_1_rad2 : (6,) tuple [1/rad²]
        α of k y (1 + α y²).
    """

    friction_nm: tuple[float, ...] = NONE
    friction_speed_rad_s: float = 1e-3
    backlash_rad: tuple[float, ...] = NONE
    hardening_1_rad2: tuple[float, ...] = NONE


class GearTorque:
    """Torque of the drives in excess of the linear spring.

    Parameters
    ----------
    settings : GearSettings
        What is there.
    model : FlexibleJointModel
        Gives the stiffness of each drive and its place among the flexible coordinates.
    """

    def __init__(self, settings: GearSettings, model: FlexibleJointModel) -> None:
        self._friction = np.array(settings.friction_nm)
        self._play = np.array(settings.backlash_rad)
        self._alpha = np.array(settings.hardening_1_rad2)
        self._speed = settings.friction_speed_rad_s
        self.active = bool(self._friction.any() or self._play.any() or self._alpha.any())
        self._springs = bool(self._play.any() or self._alpha.any())
        self._tight = self._play == 0.0
        self._friction_slope = self._friction / self._speed
        self.n_substeps = SUBSTEPS if self.active else 1
        self._stiffness = np.array([joint.drive.spring.stiffness for joint in model.spec.joints])
        self._stiffness[~np.isfinite(self._stiffness)] = 0.0
        # place.T @ x is the twist of each controller axis, place @ torque the load on x.
        self.place = np.zeros((model.n_dof, N_AXES))
        axes = model.axes.matrix
        for column, name in enumerate(model.joint_names):
            if f'{name}/drive' in model.dof_names:
                self.place[model.dof_names.index(f'{name}/drive')] = axes[:, column]

    def solve(self, free: Array, response: Array, guess: Array) -> Array:
        """Return the torque that fits the motion it causes itself (Newton).

        Friction at small speed is so steep that a torque taken from the beginning of a step would
        shake the light axes.

        Parameters
        ----------
        free : (12,) array [rad], [rad/s]
            Twists, then their rates, at the end of the step without these torques.
        response : (12, 6) array
            Change of those per unit torque held over the step; taken off.
        guess : (6,) array [N m]
            Torque to begin with, of the step before.
        """
        twist_response, speed_response = response[:N_AXES], response[N_AXES:]
        torque = guess
        motion = free - response @ torque
        for _ in range(MOST_ITERATIONS):
            wanted, slope_twist, slope_speed = self._law(motion[:N_AXES], motion[N_AXES:])
            error = torque - wanted
            if max(error.max(), -error.min()) < TORQUE_TOLERANCE_NM:
                break
            slope = slope_speed[:, None] * speed_response
            if slope_twist is not None:
                slope += slope_twist[:, None] * twist_response
            change = dgesv(slope + EYE, error)[2]
            torque = torque - change
            motion = motion + response @ change
        return np.asarray(torque)

    def _law(self, twist: Array, speed: Array) -> tuple[Array, Array | None, Array]:
        """Return the torques and their slopes over twist (None: no slope) and speed, (6,) each."""
        grip = np.tanh(speed / self._speed)
        torque = self._friction * grip
        slope_speed = self._friction_slope * (1.0 - grip * grip)
        if not self._springs:
            return torque, None, slope_speed
        free = np.minimum(np.maximum(twist, -self._play), self._play)
        wound = twist - free
        square = self._alpha * wound * wound
        torque += self._stiffness * (square * wound - free)
        engaged = (wound != 0.0) | self._tight
        slope_twist = self._stiffness * np.where(engaged, 3.0 * square, -1.0)
        return torque, slope_twist, slope_speed

    def load(self, torque: Array) -> Array:
        """Return the load on the flexible coordinates, (n_dof,)."""
        return np.asarray(self.place @ torque)
