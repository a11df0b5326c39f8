"""The flexible arm as a plant: rigid motion, gravity and vibration together, in real time.

M(q) x'' + C x' + K x = f(q, q', q'') - f_n(x, x'): exact steps of the linear part with the load
as straight lines between samples; the nonlinear torques of the gears act as further loads, held
over a substep and solved for implicitly.  The dynamics are linearised anew whenever the pose has
moved.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from modal_core.channel import ANGULAR_VELOCITY, Channel
from robot_bridge.emulator.arm_effect import ArmEffect
from robot_bridge.emulator.gear_disturbance import GearDisturbance
from robot_bridge.emulator.gear_torque import gears_with_effects, GearSettings, GearTorque
from robot_bridge.emulator.rigid_sensors import RigidSensors
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]
POSE_STEP_RAD = 2e-3


@dataclass(frozen=True, slots=True)
class ArmMotion:
    """What the arm did over some samples.

    Parameters
    ----------
    readings : (n_samples, n_channels) array [m/s²], [rad/s]
        What ideal sensors read, gravity included.
    deflection : (n_samples, n_dof) array
        Flexible coordinates.
    """

    readings: Array
    deflection: Array


@dataclass(frozen=True)
class _Linear:
    pose: Array
    step: Array
    first: Array
    second: Array
    gear: Array
    inverse_mass: Array
    damping: Array
    stiffness: Array
    jacobian: Array
    gravity: Array


class Arm:
    """The plant, advanced by whole samples.

    Parameters
    ----------
    model : FlexibleJointModel
        Mass, stiffness, kinematics of the arm.
    channels : sequence of Channel
        Sensor axes.
    pose : (n_joints,) array [rad]
        Serial motor-side angles at the beginning; the arm is at rest in its own weight.
    step_s : float [s]
        Time between samples.
    gears : GearSettings
        Nonlinear torques.
    effects : sequence of ArmEffect
        Further torques in the gears; those of structure and sensors do nothing here.
    uptime_s : float [s]
        How long the arm has been switched on.
    """

    def __init__(
        self,
        model: FlexibleJointModel,
        channels: Sequence[Channel],
        pose: Array,
        step_s: float,
        gears: GearSettings | None = None,
        effects: Sequence[ArmEffect] = (),
        uptime_s: float = 0.0,
    ) -> None:
        self.model, self.channels = model, tuple(channels)
        settings = gears_with_effects(gears or GearSettings(), effects, model.joint_names)
        self._gears = GearTorque(settings, model)
        self._disturbance = GearDisturbance(effects, model, self._gears.place)
        self._time_s = uptime_s
        self._sensors = RigidSensors(model, channels)
        self._gyro = np.array([c.unit == ANGULAR_VELOCITY for c in self.channels], dtype=bool)
        self.n_substeps = self._gears.n_substeps
        self._step_s = step_s
        self._torque = np.zeros(model.n_joints)
        self._linear = self._linearise(np.asarray(pose, float))
        still = np.zeros(model.n_joints)
        self._load = model.rigid_force(pose, still, still)
        deflection = self._settle(self._load)
        self._state = np.concatenate([deflection, np.zeros(model.n_dof)])

    def _settle(self, load: Array) -> Array:
        """Return the deflection at which springs, gears and weight balance."""
        stiffness, place = self._linear.stiffness, self._gears.place
        deflection: Array = np.asarray(np.linalg.solve(stiffness, load), float)
        if self._gears.active:
            self._gears.start(deflection)
            give = np.linalg.solve(stiffness, place)
            response = np.vstack([place.T @ give, np.zeros((place.shape[1],) * 2)])
            free = np.concatenate([place.T @ deflection, np.zeros(place.shape[1])])
            self._torque = self._gears.solve(free, response, self._torque, None)
            deflection = deflection - give @ self._torque
        return deflection

    def at_rest(self) -> Array:
        """Return what the channels read while nothing moves, (n_channels,) [m/s²], [rad/s]."""
        pose = self._linear.pose
        still = np.zeros((1, self.model.n_joints))
        deflection = self._state[: self.model.n_dof]
        rigid = self._sensors.readings(pose[None, :], still, still)[0]
        return np.asarray(rigid + self._linear.gravity @ deflection)

    def advance(self, q: Array, qd: Array, qdd: Array) -> ArmMotion:
        """Move the motor side through some samples.

        Parameters
        ----------
        q, qd, qdd : (n_samples, n_joints) array [rad], [rad/s], [rad/s²]
            Serial motor-side motion at the end of each step.
        """
        if np.max(np.abs(q[-1] - self._linear.pose)) > POSE_STEP_RAD:
            self._linear = self._linearise(q[-1])
        linear = self._linear
        load = self.model.rigid_force(q, qd, qdd)
        time_s: Array = self._time_s + self._step_s * np.arange(1.0, len(q) + 1)
        self._time_s = float(time_s[-1])
        if self._disturbance.active:
            load = load + self._disturbance.load(q, qd, time_s)
        change = None
        if self._gears.varies:
            change = self._gears.change_of_stiffness(qd @ self.model.axes.matrix.T, time_s)
        before = np.vstack([self._load, load[:-1]])
        self._load = load[-1]
        states, torques = self._integrate(before, load, change)
        n_dof = self.model.n_dof
        deflection, rate = states[:, :n_dof], states[:, n_dof:]
        force = load - rate @ linear.damping.T - deflection @ linear.stiffness.T
        force -= torques
        acceleration = force @ linear.inverse_mass.T
        readings = self._sensors.readings(q, qd, qdd)
        flexible = acceleration @ linear.jacobian.T + deflection @ linear.gravity.T
        flexible[:, self._gyro] = rate @ linear.jacobian[self._gyro].T
        readings += flexible
        return ArmMotion(readings, deflection)

    def _integrate(self, before: Array, after: Array, change: Array | None) -> tuple[Array, Array]:
        """Return the states and gear torques at the end of each sample."""
        linear = self._linear
        states = np.empty((len(after), len(self._state)))
        torques = np.zeros_like(after)
        state = self._state
        if not self._gears.active:
            push = before @ linear.first.T + after @ linear.second.T
            for index in range(len(after)):
                state = linear.step @ state + push[index]
                states[index] = state
            self._state = state
            return states, torques
        self._state, self._torque = self._integrate_gears(before, after, change, states, torques)
        return states, torques

    def _integrate_gears(
        self,
        before: Array,
        after: Array,
        change: Array | None,
        states: Array,
        torques: Array,
    ) -> tuple[Array, Array]:
        """Fill in states and torques, substep by substep; return the last ones."""
        linear, n_sub = self._linear, self.n_substeps
        place = np.ascontiguousarray(np.kron(np.eye(2), self._gears.place).T)
        response, gear, step = place @ linear.gear, linear.gear, linear.step
        # What the straight-line load adds in each substep, all of them at once.
        part = np.arange(n_sub)[None, :, None] / n_sub
        here = before[:, None] + part * (after - before)[:, None]
        there = here + (after - before)[:, None] / n_sub
        push = here @ linear.first.T + there @ linear.second.T
        state, torque = self._state, self._torque
        for index in range(len(after)):
            softer = None if change is None else change[index]
            for addition in push[index]:
                state = step @ state + addition
                torque = self._gears.solve(place @ state, response, torque, softer)
                state -= gear @ torque
            states[index] = state
            torques[index] = self._gears.load(torque)
        return state, torque

    def _linearise(self, pose: Array) -> _Linear:
        matrices = self.model.matrices(pose)
        n_dof, step_s = self.model.n_dof, self._step_s / self.n_substeps
        inverse = np.linalg.inv(matrices.M)
        # States x, x' and the load with its slope: one exponential gives the exact step.
        rate = np.zeros((4 * n_dof, 4 * n_dof))
        eye = np.eye(n_dof)
        rate[:n_dof, n_dof : 2 * n_dof] = eye
        rate[n_dof : 2 * n_dof, : 3 * n_dof] = np.hstack(
            [-inverse @ matrices.K, -inverse @ matrices.C, inverse]
        )
        rate[2 * n_dof : 3 * n_dof, 3 * n_dof :] = eye
        full = expm(rate * step_s)[: 2 * n_dof]
        held = full[:, 2 * n_dof : 3 * n_dof]
        second = full[:, 3 * n_dof :] / step_s
        return _Linear(
            pose=pose.copy(),
            step=np.ascontiguousarray(full[:, : 2 * n_dof]),
            first=held - second,
            second=second,
            gear=held @ self._gears.place,
            inverse_mass=np.asarray(inverse, float),
            damping=matrices.C,
            stiffness=matrices.K,
            jacobian=self.model.sensor_jacobian(pose, self.channels),
            gravity=self.model.gravity_jacobian(pose, self.channels),
        )
