"""Stepping an arm through one recording: classical Runge-Kutta about MuJoCo's forward dynamics.

The motors' angles are prescribed; each twists its gear, e = A (q - q_m), and the gears' torques
are the only ones between motor and link. Everything else the engine computes itself.
"""

from dataclasses import dataclass

import mujoco
import numpy as np

STEP_S = 1.0 / 1500.0
SKIP_SENSORS, COMPUTE = 1, 0
# Of the stiffest spring: what gives way more is a gear between its flanks that nothing loads.
SLACK = 1e-9
# Of one step towards rest [m, rad]: less than any play, whose flanks it would else jump over; each
# shorter than the one before, since a tooth that hardly leans on its flank chatters.
FALL, SHORTER, MOST_STEPS = 3e-5, 0.97, 300


@dataclass
class Motion:
    """Prescribed motion on a grid of half steps: (n, joints) positions, rates [rad, rad/s]."""

    position: np.ndarray
    velocity: np.ndarray


def simulate(arm, laws, pose, motion, finer=1):
    """Return accelerometer readings, one row every ``STEP_S``, gravity included.

    Parameters
    ----------
    arm : Compiled
        The arm.
    laws : sequence
        Laws of joints (``laws``): torques beside the drives' springs, with states of their own.
    pose : (n_joints,) array [rad]
        About which the motors move.
    motion : Motion
        On half steps, less the pose, from rest.
    finer : int
        Steps in each: the stiffest bearings swing at 500 Hz, and classical steps stay stable up
        to 0.9 ms; bristles are stiffer.
    """
    step_s = STEP_S / finer
    run = Run(arm, laws, pose, motion, step_s)
    state = run.at_rest()
    rows = []
    for number in range((len(motion.position) - 1) // 2):
        first = run.rate(2 * number, state, read=number % finer == 0)
        if number % finer == 0:
            rows.append(run.data.sensordata.copy())
        second = run.rate(2 * number + 1, state + 0.5 * step_s * first)
        third = run.rate(2 * number + 1, state + 0.5 * step_s * second)
        last = run.rate(2 * number + 2, state + step_s * third)
        state = state + step_s / 6.0 * (first + 2.0 * (second + third) + last)
    found = np.array(rows)
    if not np.all(np.isfinite(found)):
        raise FloatingPointError('the simulated arm does not hold together: a shorter step')
    return found


class Run:
    """One recording: its state is every coordinate, every rate, and what the laws remember."""

    def __init__(self, arm, laws, pose, motion, step_s):
        self.arm, self.laws, self.pose, self.motion = arm, laws, np.asarray(pose), motion
        self.step_s = step_s
        self.data = mujoco.MjData(arm.model)
        self.n = arm.model.nv
        self.parts = []
        start = 2 * self.n
        for law in laws:
            self.parts.append(slice(start, start + law.states))
            start += law.states
        self.size = start
        self.mass = np.zeros((self.n, self.n))

    def at_rest(self):
        """Return the state in which the arm hangs still in its springs."""
        arm, data = self.arm, self.data
        state = np.zeros(self.size)
        state[arm.drives] = self.pose
        self._tie(state)
        self._settle(state, (), np.inf)
        self._settle(state, self.laws, FALL)
        twist = state[arm.drives] - self.pose
        for law, part in zip(self.laws, self.parts, strict=True):
            state[part] = law.begin(arm.couple @ twist)
        self.rate(0, state)
        # Column by column: the engine's releases keep the matrix under different names.
        for unit, column in zip(np.eye(self.n), self.mass, strict=True):
            mujoco.mj_mulM(arm.model, data, column, unit)
        return state

    def _tie(self, state):
        """Tie cables so that they pull as they should before the arm gives way."""
        model, data = self.arm.model, self.data
        self._put(state)
        mujoco.mj_forward(model, data)
        for number, pull in self.arm.pulls.items():
            short = pull / model.tendon_stiffness[number]
            model.tendon_lengthspring[number] = data.ten_length[number] - short

    def _settle(self, state, laws, most):
        """Move a state to where the arm and some laws hang still, so far in a step at most."""
        step = 1e-7
        for number in range(MOST_STEPS):
            base = self._force(state, laws)
            slope = np.empty((self.n, self.n))
            for column in range(self.n):
                moved = state.copy()
                moved[column] += step
                slope[:, column] = (self._force(moved, laws) - base) / step
            # Always down: between its flanks a gear under an upright arm falls away from rest.
            stiffness, ways = np.linalg.eigh(-0.5 * (slope + slope.T))
            stiffness = np.maximum(np.abs(stiffness), SLACK * stiffness.max())
            change = ways @ (ways.T @ base / stiffness)
            size = np.abs(change).max()
            state[: self.n] += change * min(1.0, most * SHORTER**number / max(size, step**2))
            if size < 1e-13:
                break

    def read_at_rest(self, state):
        """Return what the sensors read while the arm hangs still."""
        self._force(state, self.laws, read=True)
        return self.data.sensordata.copy()

    def _force(self, state, laws, read=False):
        """Return the generalised force on the arm at rest in its own springs and some laws."""
        self._put(state)
        twist = self.arm.couple @ (state[self.arm.drives] - self.pose)
        torque = -self.arm.k * twist + sum(
            (law.at_rest(twist) for law in laws), np.zeros(len(twist))
        )
        self.data.qfrc_applied[:] = 0.0
        self.data.qfrc_applied[self.arm.drives] = self.arm.couple.T @ torque
        mujoco.mj_forwardSkip(self.arm.model, self.data, COMPUTE, 0 if read else SKIP_SENSORS)
        return self.data.qfrc_smooth.copy()

    def _put(self, state):
        self.data.qpos[:] = state[: self.n]
        self.data.qvel[:] = state[self.n : 2 * self.n]

    def rate(self, half_step, state, read=False):
        """Return the derivative of the state; ``read`` has the sensors evaluated."""
        arm, data, n = self.arm, self.data, self.n
        self._put(state)
        position = self.motion.position[half_step]
        velocity = self.motion.velocity[half_step]
        drives = arm.drives
        twist = arm.couple @ (data.qpos[drives] - self.pose - position)
        rate = arm.couple @ (data.qvel[drives] - velocity)
        torque = -arm.k * twist - arm.c * rate
        out = np.empty(self.size)
        time = 0.5 * half_step * self.step_s
        for law, part in zip(self.laws, self.parts, strict=True):
            inner = state[part]
            more, change = law.torque(time, twist, rate, position, velocity, inner)
            torque += more
            out[part] = change
        applied = np.zeros(n)
        applied[drives] = arm.couple.T @ torque
        if arm.mass_damping:
            free = data.qvel.copy()
            free[drives] -= velocity
            applied -= arm.mass_damping * (self.mass @ free)
        data.qfrc_applied[:] = applied
        mujoco.mj_forwardSkip(arm.model, data, COMPUTE, 0 if read else SKIP_SENSORS)
        out[:n] = data.qvel
        out[n : 2 * n] = data.qacc
        return out
