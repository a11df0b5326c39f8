"""What gears do beyond springs and dampers: friction, play, hardening, slip, change with speed."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dgesv

from robot_bridge.emulator.arm_effect import ArmEffect
from robot_bridge.emulator.arm_structure import check_place
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
        Coulomb friction against the rate of the twist.
    friction_speed_rad_s : float [rad/s]
        Rate at which friction is developed.
    backlash_rad : (6,) tuple [rad]
        Half of the free play.
    hardening_1_rad2 : (6,) tuple [1/rad²]
        α of k y (1 + α y²).
    speed_stiffness_s_rad : (6,) tuple [s/rad]
        β of k (1 + β |speed of the axis|).
    slip_share, slip_limit_rad : (6,) tuple, (6,) tuple [rad]
        A further spring of this share that slips at this twist (Dahl).
    drift_change, drift_time_s : (6,) tuple, (6,) tuple [s]
        k (1 + change (1 - exp(-t / time))) since the arm was switched on.
    """

    friction_nm: tuple[float, ...] = NONE
    friction_speed_rad_s: float = 1e-3
    backlash_rad: tuple[float, ...] = NONE
    hardening_1_rad2: tuple[float, ...] = NONE
    speed_stiffness_s_rad: tuple[float, ...] = NONE
    slip_share: tuple[float, ...] = NONE
    slip_limit_rad: tuple[float, ...] = (1e-4,) * N_AXES
    drift_change: tuple[float, ...] = NONE
    drift_time_s: tuple[float, ...] = (600.0,) * N_AXES


# Effect: its values and the settings they are added to, or put in place of.
ADDED = {
    'coulomb_friction': {'torque': 'friction_nm'},
    'backlash': {'half_gap': 'backlash_rad'},
    'cubic_stiffness': {'alpha': 'hardening_1_rad2'},
    'speed_dependent_stiffness': {'beta': 'speed_stiffness_s_rad'},
    'hysteresis': {'share': 'slip_share'},
    'thermal_drift': {'change': 'drift_change'},
}
REPLACED = {
    'hysteresis': {'limit': 'slip_limit_rad'},
    'thermal_drift': {'time_constant': 'drift_time_s'},
}


def gears_with_effects(
    settings: GearSettings, effects: Sequence[ArmEffect], joint_names: Sequence[str]
) -> GearSettings:
    """Return the settings with the effects that are torques in gears; others do nothing.

    Raises
    ------
    SettingsError
        No such joint.
    """
    for effect in effects:
        if effect.type not in ADDED:
            continue
        check_place(effect, joint_names)
        axis = list(joint_names).index(effect.place)
        for table, keep in ((ADDED, 1.0), (REPLACED, 0.0)):
            for name, target in table.get(effect.type, {}).items():
                values = list(getattr(settings, target))
                values[axis] = keep * values[axis] + effect.number(name)
                change: dict[str, Any] = {target: tuple(values)}
                settings = replace(settings, **change)
    return settings


class GearTorque:
    """Torque of the drives in excess of the linear spring.

    Parameters
    ----------
    settings : GearSettings
        What is there.
    model : FlexibleJointModel
        Gives the stiffness of each drive and its place among the flexible coordinates.

    References
    ----------
    Mohammadi (hardening); Tunc and Gonul (2021), doi:10.1016/j.cirp.2021.04.006 (speed); Dahl
    (1976), doi:10.2514/3.61511 (slip).
    """

    def __init__(self, settings: GearSettings, model: FlexibleJointModel) -> None:
        self._settings = settings
        self._friction = np.array(settings.friction_nm)
        self._play = np.array(settings.backlash_rad)
        self._alpha = np.array(settings.hardening_1_rad2)
        self._speed = settings.friction_speed_rad_s
        self._beta = np.array(settings.speed_stiffness_s_rad)
        self._drift = np.array(settings.drift_change)
        self._limit = np.array(settings.slip_limit_rad)
        share = np.array(settings.slip_share)
        self._slips, self._rubs = bool(share.any()), bool(self._friction.any())
        self.varies = bool(self._beta.any() or self._drift.any())
        self._springs = bool(self._play.any() or self._alpha.any() or self.varies)
        self.active = self._rubs or self._springs or self._slips
        self.n_substeps = SUBSTEPS if self.active else 1
        self._tight = self._play == 0.0
        self._friction_slope = self._friction / self._speed
        self._stiffness = np.array([joint.drive.spring.stiffness for joint in model.spec.joints])
        self._stiffness[~np.isfinite(self._stiffness)] = 0.0
        self._slip_stiffness = share * self._stiffness
        self._wound = self._twist = np.zeros(N_AXES)
        # place.T @ x is the twist of each controller axis, place @ torque the load on x.
        self.place = drive_places(model)

    def start(self, deflection: Array) -> None:
        """Let slipping springs be slack at this deflection, (n_dof,)."""
        self._twist = deflection @ self.place

    def change_of_stiffness(self, speed: Array, time_s: Array) -> Array:
        """Return the relative change of each spring, (n_samples, 6).

        Parameters
        ----------
        speed : (n_samples, 6) array [rad/s]
            Of the controller axes.
        time_s : (n_samples,) array [s]
            Since the arm was switched on.
        """
        warmth = 1.0 - np.exp(-time_s[:, None] / np.array(self._settings.drift_time_s))
        return np.asarray(self._beta * np.abs(speed) + self._drift * warmth)

    def solve(self, free: Array, response: Array, guess: Array, change: Array | None) -> Array:
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
        change : (6,) array or None
            Relative change of the springs now.
        """
        twist_response, speed_response = response[:N_AXES], response[N_AXES:]
        torque = guess
        motion = free - response @ torque
        for _ in range(MOST_ITERATIONS):
            wanted, slope_twist, slope_speed = self._law(motion[:N_AXES], motion[N_AXES:], change)
            error = torque - wanted
            if max(error.max(), -error.min()) < TORQUE_TOLERANCE_NM:
                break
            slope = EYE.copy()
            if slope_speed is not None:
                slope += slope_speed[:, None] * speed_response
            if slope_twist is not None:
                slope += slope_twist[:, None] * twist_response
            step = dgesv(slope, error)[2]
            torque = torque - step
            motion = motion + response @ step
        if self._slips:
            self._wound = self._slip(motion[:N_AXES])[0]
            self._twist = motion[:N_AXES].copy()
        return np.asarray(torque)

    def _law(
        self, twist: Array, speed: Array, change: Array | None
    ) -> tuple[Array, Array | None, Array | None]:
        """Return the torques and their slopes over twist and speed (None: no slope), (6,) each."""
        torque, slope_twist, slope_speed = np.zeros(N_AXES), None, None
        if self._rubs:
            grip = np.tanh(speed / self._speed)
            torque = self._friction * grip
            slope_speed = self._friction_slope * (1.0 - grip * grip)
        if self._springs:
            wound = twist - np.minimum(np.maximum(twist, -self._play), self._play)
            square = self._alpha * wound * wound
            factor = 1.0 if change is None else 1.0 + change
            torque = torque + self._stiffness * (factor * (1.0 + square) * wound - twist)
            engaged = (wound != 0.0) | self._tight
            slope_twist = self._stiffness * (engaged * factor * (1.0 + 3.0 * square) - 1.0)
        if self._slips:
            held, slope = self._slip(twist)
            torque = torque + self._slip_stiffness * held
            slope = self._slip_stiffness * slope
            slope_twist = slope if slope_twist is None else slope_twist + slope
        return torque, slope_twist, slope_speed

    def _slip(self, twist: Array) -> tuple[Array, Array]:
        """Return how far the slipping springs are wound and the slope of that over the twist.

        dz/dy = 1 - sign(y') z / z_max, solved exactly for a twist that goes one way in a step.
        """
        way = twist - self._twist
        sign = np.sign(way)
        left = (sign * self._limit - self._wound) * np.exp(-np.abs(way) / self._limit)
        wound = np.where(way == 0.0, self._wound, sign * self._limit - left)
        return wound, 1.0 - sign * wound / self._limit

    def load(self, torque: Array) -> Array:
        """Return the load on the flexible coordinates, (n_dof,)."""
        return np.asarray(self.place @ torque)


def drive_places(model: FlexibleJointModel) -> Array:
    """Return the load on the flexible coordinates per torque of each drive, (n_dof, n_joints).

    A motor behind a soft servo takes the reaction.
    """
    place = np.zeros((model.n_dof, model.n_joints))
    axes, names = model.axes.matrix, model.dof_names
    for column, joint in enumerate(model.joint_names):
        if f'{joint}/drive' in names:
            place[names.index(f'{joint}/drive')] = axes[:, column]
        if f'{joint}/motor' in names:
            place[names.index(f'{joint}/motor'), column] = -1.0
    return place
