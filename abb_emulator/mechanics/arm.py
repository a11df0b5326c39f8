"""The flexible arm as a plant: rigid motion, gravity and vibration together, in real time.

Springs and dampers about a nearby pose take exact steps; all that is nonlinear in the arm, such as
its changing mass, Coriolis forces and gravity at the bent pose, comes from a recursion over the
whole arm at every sample and drives the linear part as a further load.  The nonlinear torques of
the gears are held over a substep and solved for implicitly.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from abb_emulator.mechanics.arm_effect import ArmEffect
from abb_emulator.mechanics.gear_disturbance import GearDisturbance
from abb_emulator.mechanics.gear_friction import GearFriction
from abb_emulator.mechanics.gear_place import drive_places
from abb_emulator.mechanics.gear_settings import gears_with_effects, GearSettings
from abb_emulator.mechanics.gear_springs import GearSprings
from abb_emulator.mechanics.linear_step import LinearStep
from abb_emulator.mechanics.sensor_readings import SensorReadings
from abb_emulator.mechanics.whole_arm import WholeArm
from abb_emulator.process import SpindleProcess
from modal_core.channel import Channel
from modal_core.units import ANGULAR_VELOCITY
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]
POSE_STEP_RAD = 0.015
MOST_SETTLING_STEPS = 100
SOFTEST = 0.9
SETTLED_RAD = 1e-13


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
    process : SpindleProcess or None
        A spindle at work at the tool.
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
        process: SpindleProcess | None = None,
    ) -> None:
        self.model, self.channels = model, tuple(channels)
        settings = gears_with_effects(gears or GearSettings(), effects, model.joint_names)
        self.process = process
        self._place = drive_places(model)
        self._springs, self._friction = GearSprings(settings, model), GearFriction(settings)
        self._disturbance = GearDisturbance(effects, model, self._place)
        self._sensors = SensorReadings(model, self.channels)
        self._whole = WholeArm(model, self._sensors.joints)
        self._gyro = np.array([c.unit == ANGULAR_VELOCITY for c in self.channels], dtype=bool)
        self._mass_damping = model.spec.damping.mass_proportional_1_s
        self._step_s, self._time_s = step_s, uptime_s
        self._rise = self._last_rise = np.zeros(model.n_dof)
        self._push = np.zeros(model.n_dof)
        self._state = self._settle(np.asarray(pose, float))
        self._still = self._state[: model.n_dof].copy()
        self._linearise(np.asarray(pose, float))

    @property
    def state(self) -> Array:
        """Flexible coordinates and their speeds, (2 n_dof,), a copy."""
        return self._state.copy()

    def let_go(self, state: Array, rise: Array, last_rise: Array) -> None:
        """Go on from another state of motion, for instance of a free decay.

        Parameters
        ----------
        state : (2 n_dof,) array
            Flexible coordinates and their speeds.
        rise, last_rise : (n_dof,) array
            Accelerations of the coordinates, now and a step ago.
        """
        self._state, self._rise, self._last_rise = state.copy(), rise, last_rise
        self._push = rise - self._linear.rise @ state

    def at_rest(self) -> Array:
        """Return what the channels read while nothing moves, (n_channels,) [m/s²], [rad/s]."""
        still = np.zeros((1, self.model.n_joints))
        motor = self._whole.motor_side(self._linear.pose[None, :], still, still)
        self._whole.unbalanced(motor[0], self._state, np.zeros(self.model.n_dof))
        motion = np.empty((1, self._whole.n_motion))
        self._whole.motion(motion[0])
        return np.asarray(self._sensors.readings(motion)[0])

    def advance(self, q: Array, qd: Array, qdd: Array) -> ArmMotion:
        """Move the motor side through some samples.

        Parameters
        ----------
        q, qd, qdd : (n_samples, n_joints) array [rad], [rad/s], [rad/s²]
            Serial motor-side motion at the end of each step.
        """
        time_s: Array = self._time_s + self._step_s * np.arange(1.0, len(q) + 1)
        self._time_s = float(time_s[-1])
        factor = self._springs.factor(qd @ self.model.axes.matrix.T, time_s)
        angle = q @ self.model.axes.matrix.T
        extra = self._disturbance.load(q, qd, time_s)
        if self.process is not None:
            self.process.prepare(len(q))
        motor = self._whole.motor_side(q, qd, qdd)
        parts, begin = [], 0
        while begin < len(q):
            end = self._near(q, begin)
            here = slice(begin, end)
            parts.append(self._run(motor[here], extra[here], factor[here], angle[here]))
            begin = end
        return ArmMotion(
            np.concatenate([part.readings for part in parts]),
            np.concatenate([part.deflection for part in parts]),
        )

    def _near(self, q: Array, begin: int) -> int:
        """Return up to which sample the arm is near the pose it is linearised at; move that."""
        if np.max(np.abs(q[begin] - self._linear.pose)) > POSE_STEP_RAD:
            ahead = _first(np.max(np.abs(q[begin:] - q[begin]), axis=1) > POSE_STEP_RAD)
            self._linearise(q[begin + ahead - 1])
        away = np.max(np.abs(q[begin:] - self._linear.pose), axis=1) > POSE_STEP_RAD
        # At least one sample, should the arm jump.
        return begin + max(_first(away), 1)

    def _run(self, motor: Array, extra: Array, factor: Array, angle: Array) -> ArmMotion:
        """Take some samples about one pose."""
        linear, n_dof, step_s = self._linear, self.model.n_dof, self._step_s
        states, missed = np.empty((2, len(extra), 2 * n_dof))
        motion = np.empty((len(extra), self._whole.n_motion))
        state, rise, last_rise = self._state, self._rise, self._last_rise
        for index in range(len(extra)):
            # Foresee the end of the step, with x'' on a straight line.
            next_rise = 2.0 * rise - last_rise
            x, speed = state[:n_dof], state[n_dof:]
            next_x = x + step_s * (speed + (step_s / 6.0) * (2.0 * rise + next_rise))
            next_speed = speed + (0.5 * step_s) * (rise + next_rise)
            foreseen = np.concatenate([next_x, next_speed])
            force = extra[index] + self._whole.unbalanced(motor[index], foreseen, next_rise)
            if self.process is not None:
                force += self._at_tool(self.process, x, next_x)
            self._whole.motion(motion[index])
            push = next_rise + linear.inverse_mass @ force - linear.rise @ foreseen
            state = self._step(state, push, next_x, factor[index], angle[index])
            last_rise = rise
            rise = self._push + linear.rise @ state
            if self._friction.active:
                rise -= linear.gear_rise @ self._friction.torque
            states[index] = state
            missed[index, :n_dof] = rise - next_rise - self._mass_damping * next_speed
            missed[index, n_dof:] = state[n_dof:] - next_speed
        self._state, self._rise, self._last_rise = state, rise, last_rise
        readings = self._sensors.readings(motion)
        late = missed[:, :n_dof] @ linear.jacobian.T
        late[:, self._gyro] = missed[:, n_dof:] @ linear.jacobian[self._gyro].T
        return ArmMotion(readings + late, states[:, :n_dof])

    def _at_tool(self, process: SpindleProcess, x: Array, next_x: Array) -> Array:
        """Return the load of the process at the end of a step, (n_dof,)."""
        begin, end = self._tool @ (x - self._still), self._tool @ (next_x - self._still)
        return np.asarray(process.step(begin, end) @ self._tool)

    def _step(
        self, state: Array, push: Array, next_x: Array, factor: Array, angle: Array
    ) -> Array:
        """Return the state at the end of a sample; ``push`` is u there without the gears."""
        linear, n_dof, place = self._linear, self.model.n_dof, self._place
        if self._springs.active:
            twist = next_x @ place
            torque, slope = self._springs.torque(twist, factor, angle)
            push = push - linear.gear_rise @ torque
            found = linear.advance @ np.concatenate([state, self._push, push])
            # Where the twist was foreseen wrongly, each spring follows its slope.
            more = slope * (found[:n_dof] @ place - twist) / (1.0 + slope * self._give)
            push -= linear.gear_rise @ more
            found -= linear.rising @ more
        else:
            found = linear.advance @ np.concatenate([state, self._push, push])
        if self._friction.active:
            found -= linear.held @ self._friction.solve(found[n_dof:] @ place, self._response)
        if self._springs.active:
            self._springs.arrive(found[:n_dof] @ place, angle)
        self._push = push
        return np.asarray(found)

    def _settle(self, pose: Array) -> Array:
        """Return the state in which springs, gears and weight balance (Newton).

        An axis without weight rests nowhere in its play in particular; it begins near there.
        """
        n_dof, place = self.model.n_dof, self._place
        stiffness, still = self.model.matrices(pose).K, np.zeros((1, self.model.n_joints))
        angle = self.model.to_controller(pose)
        softest = -SOFTEST * self._springs.stiffness
        factor = self._springs.factor(still, np.array([self._time_s]))[0]
        state, last = np.zeros(2 * n_dof), np.inf
        step: Array = np.zeros(n_dof)
        state[:n_dof] = self.model.static_deflection(pose)
        for _ in range(MOST_SETTLING_STEPS):
            motor = self._whole.motor_side(pose[None, :], still, still)[0]
            force = self._whole.unbalanced(motor, state, np.zeros(n_dof))
            self._springs.rest(state[:n_dof] @ place, angle)
            torque, slope = self._springs.torque(state[:n_dof] @ place, factor, angle)
            force -= place @ torque
            # Work it could do: forces and torques in one measure.
            size = float(force @ np.linalg.solve(stiffness, force))
            if size > last:
                step = 0.5 * step
                state[:n_dof] -= step
                continue
            last = size
            tangent = stiffness + (place * np.maximum(slope, softest)) @ place.T
            step = np.asarray(np.linalg.solve(tangent, force), float)
            state[:n_dof] += step
            if np.max(np.abs(step)) < SETTLED_RAD:
                break
        return state

    def _linearise(self, pose: Array) -> None:
        """Linearise about another pose; u takes over what the linear part now leaves."""
        self._linear = linear = LinearStep.at(
            self.model, pose, self.channels, self._step_s, self._place
        )
        self._response = self._place.T @ linear.held[self.model.n_dof :]
        if self.process is not None:
            self._tool = self.model.sensor_jacobian(pose, self.process.channels)
        self._give = np.diag(self._place.T @ linear.rising[: self.model.n_dof])
        self._push = self._rise - linear.rise @ self._state
        self._push += linear.gear_rise @ self._friction.torque


def _first(flags: NDArray[np.bool_]) -> int:
    """Return the place of the first True; the length when there is none."""
    return int(np.argmax(flags)) if flags.any() else len(flags)
