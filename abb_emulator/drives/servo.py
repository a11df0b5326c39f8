"""Drives: dead time, second-order servo, friction, encoder; all on controller axes.

Each axis follows its command as q'' = ω² (command - q) - 2ζω q' - friction.  What comes out is the
motor-side angle behind the gear: the arm's vibration does not show in it.
"""

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from abb_emulator.of_axes import of_axes
from modal_core.settings.schema import setting

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class ServoSettings:
    """Of all axes; none of these figures is published, all are assumptions.

    Parameters
    ----------
    bandwidth_hz : float [Hz]
        Natural frequency of the servo.
    damping_ratio : float
        Of the servo.
    dead_time_s : float [s]
        From the controller's command to the drive.
    friction_deg_s2 : float [deg/s²]
        Coulomb friction the servo fights, as an acceleration.
    friction_speed_deg_s : float [deg/s]
        Speed at which friction is developed.
    encoder_counts : int
        Counts per motor turn.
    gear_ratio : (6,) tuple
        Motor turns per axis turn.
    """

    bandwidth_hz: float = setting(25.0, 'natural frequency of the servo [Hz]', 0.1, 1000.0)
    damping_ratio: float = setting(0.7, 'of the servo', 0.01, 10.0)
    dead_time_s: float = setting(0.020, "from the controller's command to the drive [s]", 0.0, 1.0)
    friction_deg_s2: float = setting(
        0.0, 'Coulomb friction the servo fights, as an acceleration [deg/s²]', 0.0, 1e6
    )
    friction_speed_deg_s: float = setting(
        0.5, 'speed at which friction is developed [deg/s]', 1e-6, 1000.0
    )
    encoder_counts: int = setting(8192, 'counts per motor turn', 1, 2**31)
    gear_ratio: tuple[float, ...] = setting(
        (200.0, 200.0, 180.0, 120.0, 120.0, 100.0), 'motor turns per axis turn', 0.01, 1e5
    )


@dataclass(frozen=True, slots=True)
class MotorMotion:
    """Motor-side motion of a stretch of plant steps, (n_steps, 6) arrays on controller axes.

    Parameters
    ----------
    position_deg, velocity_deg_s, acceleration_deg_s2 : (n_steps, 6) array
        At the end of each step.
    """

    position_deg: Array
    velocity_deg_s: Array
    acceleration_deg_s2: Array


class Servo:
    """Six drives, advanced by whole plant steps.

    Parameters
    ----------
    settings : ServoSettings
        Of the drives.
    start_deg : (6,) array [deg]
        Where the axes stand.
    step_s : float [s]
        Plant step.
    """

    def __init__(self, settings: ServoSettings, start_deg: Array, step_s: float) -> None:
        self.settings = settings = of_axes(settings, len(start_deg))
        start = np.array(start_deg, float)
        self._state = np.vstack([start, np.zeros_like(start)])
        n_delay = max(round(settings.dead_time_s / step_s), 0)
        self._queue = np.tile(start, (n_delay + 1, 1))
        self._omega = 2.0 * math.pi * settings.bandwidth_hz
        self._step, self._first, self._second, self._kick = self._discrete(step_s)
        self._count_deg = 360.0 / (settings.encoder_counts * np.array(settings.gear_ratio))

    @property
    def position_deg(self) -> Array:
        """Motor-side angles, (6,) [deg]."""
        return np.array(self._state[0])

    def measured_deg(self, late_s: float) -> Array:
        """Return what the encoders count a part of a plant step after the last, (6,) [deg]."""
        now = self._state[0] + late_s * self._state[1]
        return np.asarray(np.round(now / self._count_deg) * self._count_deg)

    def advance(self, commands_deg: Array) -> MotorMotion:
        """Follow one command per plant step.

        Parameters
        ----------
        commands_deg : (n_steps, 6) array [deg]
            Command at the end of each step.
        """
        n_steps = len(commands_deg)
        queue = np.concatenate([self._queue, commands_deg])
        self._queue = queue[n_steps:]
        pull = queue[:n_steps], queue[1 : n_steps + 1]
        states = np.empty((n_steps, 2, commands_deg.shape[1]))
        state = self._state
        drive = self._first * pull[0][:, None, :] + self._second * pull[1][:, None, :]
        rough = self.settings.friction_deg_s2 > 0.0
        for index in range(n_steps):
            push = drive[index]
            if rough:
                push = push - self._kick * self._friction(state[1])
            state = self._step @ state + push
            states[index] = state
        self._state = state
        position, velocity = states[:, 0], states[:, 1]
        acceleration = self._omega**2 * (pull[1] - position)
        acceleration -= 2.0 * self.settings.damping_ratio * self._omega * velocity
        if rough:
            acceleration -= self._friction(velocity)
        return MotorMotion(position, velocity, acceleration)

    def _friction(self, velocity_deg_s: Array) -> Array:
        speed = velocity_deg_s / self.settings.friction_speed_deg_s
        return np.asarray(self.settings.friction_deg_s2 * np.tanh(speed))

    def _discrete(self, step_s: float) -> tuple[Array, ...]:
        """Return the exact step for commands that are straight lines within it."""
        omega, zeta = self._omega, self.settings.damping_ratio
        # States: position, velocity, command, slope of the command, constant friction.
        rate = np.zeros((5, 5))
        rate[0, 1] = rate[2, 3] = 1.0
        rate[1] = [-(omega**2), -2.0 * zeta * omega, omega**2, 0.0, 1.0]
        full = expm(rate * step_s)
        second = full[:2, 3:4] / step_s
        return full[:2, :2], full[:2, 2:3] - second, second, full[:2, 4:5]
