"""Controller, drives, arm and sensors together, advanced cycle by cycle; no clock and no ROS."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abb_emulator.controller import Controller
from abb_emulator.controller_settings import ControllerSettings
from abb_emulator.drives import Servo, ServoSettings
from abb_emulator.egm import UdpClient
from abb_emulator.mechanics import (
    Arm,
    ArmEffect,
    GAIN_SIGMA,
    GearSettings,
    PLACE_SIGMA_M,
    with_effects,
    with_tolerances,
)
from abb_emulator.process import ProcessSettings, SpindleProcess
from abb_emulator.sensing import DelayLine, SensorArray, SensorErrors, SensorSettings
from modal_core.channel import Channel
from modal_core.errors import SettingsError
from modal_core.settings.schema import setting
from modal_core.units import ANGULAR_VELOCITY
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]
PPM = 1e-6
PARTS: dict[str, type[Any]] = {
    'servo': ServoSettings,
    'gears': GearSettings,
    'sensors': SensorSettings,
    'controller': ControllerSettings,
    'process': ProcessSettings,
}
"""Settings of the parts, by field of :class:`CellSettings`."""


@dataclass(frozen=True, slots=True)
class CellSettings:
    """Everything of the emulated cell.

    Parameters
    ----------
    sample_rate_hz : float [Hz]
        Of the accelerometers, and steps of the plant.
    block_samples : int
        Rows per block.
    seed : int
        Of noise, bias and link faults.
    effects : tuple of ArmEffect
        What the arm has and its model lacks.
    tolerance : float
        Ordinary deviations of arm and sensors from the model: masses 1 %, springs 1.5 %, dampers
        8 %, sensor places 3 mm, gains 0.7 %, times this.
    tolerance_seed : int
        Of those.
    uptime_s : float [s]
        How long the arm has been switched on at the beginning.
    controller, servo, gears, sensors, process
        Settings of the parts.
    """

    sample_rate_hz: float = setting(2048.0, 'of the accelerometers [Hz]', 1.0, 1e5)
    block_samples: int = setting(64, 'rows per acceleration_block', 1, 100_000)
    seed: int = setting(1, 'of noise, bias and link faults', 0, 2**63 - 1)
    effects: tuple[ArmEffect, ...] = ()
    tolerance: float = setting(
        0.0, 'ordinary deviations from the model; 1 is what every arm has', 0.0, 100.0
    )
    tolerance_seed: int = setting(1, 'of those', 0, 2**63 - 1)
    uptime_s: float = setting(0.0, 'how long the arm has been switched on [s]', 0.0, 1e9)
    controller: ControllerSettings = field(default_factory=ControllerSettings)
    servo: ServoSettings = field(default_factory=ServoSettings)
    gears: GearSettings = field(default_factory=GearSettings)
    sensors: SensorSettings = field(default_factory=SensorSettings)
    process: ProcessSettings = field(default_factory=ProcessSettings)


@dataclass(frozen=True, slots=True)
class SensorBlock:
    """One block of samples.

    Parameters
    ----------
    first_index : int
        Running number of the first row.
    acceleration : (n_samples, n_channels) float32 array [m/s²]
        As recorded.
    """

    first_index: int
    acceleration: NDArray[np.float32]


class MotorSide:
    """Controller and drives: everything the EGM link sees.

    Parameters
    ----------
    model : FlexibleJointModel
        The robot.
    start_deg : (6,) array [deg]
        Where the axes stand, in controller angles.
    client : UdpClient or None
        Link to the sensor.
    settings : CellSettings
        Of the cell.
    start_time_s : float [s] or None
        Of the controller's clock.
    """

    def __init__(
        self,
        model: FlexibleJointModel,
        start_deg: Array,
        client: UdpClient | None,
        settings: CellSettings,
        start_time_s: float | None = None,
    ) -> None:
        self.controller = Controller(
            model, start_deg, client, settings.controller, start_time_s=start_time_s
        )
        # The recorder's clock sets the steps, so that its samples are exact.
        self.true_rate_hz = settings.sample_rate_hz * (
            1.0 + settings.sensors.clock_error_ppm * PPM
        )
        self._servo = Servo(settings.servo, start_deg, 1.0 / self.true_rate_hz)
        self._to_serial = np.linalg.inv(model.axes.matrix).T
        self._cycle_s = settings.controller.cycle_s
        self._n_cycles = self._n_steps = 0

    def cycle(self) -> tuple[Array, Array, Array]:
        """Advance by one controller cycle.

        Returns
        -------
        tuple of three (n_steps, 6) arrays [rad], [rad/s], [rad/s²]
            Serial motor-side motion at the samples that fall into the cycle.
        """
        controller = self.controller
        before = controller.axes.planned_deg
        after = controller.tick()
        begin_s = self._n_cycles * self._cycle_s
        self._n_cycles += 1
        n_end = int(self._n_cycles * self._cycle_s * self.true_rate_hz)
        times = np.arange(self._n_steps + 1, n_end + 1) / self.true_rate_hz
        self._n_steps = n_end
        part = ((times - begin_s) / self._cycle_s)[:, None]
        motion = self._servo.advance(before + part * (after - before))
        late_s = self._n_cycles * self._cycle_s - n_end / self.true_rate_hz
        controller.axes.measured_deg = self._servo.measured_deg(late_s)
        controller.report()
        return (
            np.radians(motion.position_deg) @ self._to_serial,
            np.radians(motion.velocity_deg_s) @ self._to_serial,
            np.radians(motion.acceleration_deg_s2) @ self._to_serial,
        )


class ArmSide:
    """Arm and sensors: turns motor motion into blocks of samples.

    Parameters
    ----------
    model : FlexibleJointModel
        The robot.
    channels : sequence of Channel
        Sensor axes.
    start_deg : (6,) array [deg]
        Where the axes stand, in controller angles.
    settings : CellSettings
        Of the cell.
    """

    def __init__(
        self,
        model: FlexibleJointModel,
        channels: Sequence[Channel],
        start_deg: Array,
        settings: CellSettings,
    ) -> None:
        pose = model.axes.to_serial(np.radians(start_deg))
        rate_hz = settings.sample_rate_hz * (1.0 + settings.sensors.clock_error_ppm * PPM)
        random = np.random.default_rng(settings.tolerance_seed)
        arm = with_tolerances(model, settings.tolerance, random)
        places = _misplaced(channels, settings.tolerance, random)
        self._gain = 1.0 + settings.tolerance * GAIN_SIGMA * random.standard_normal(len(places))
        effects = settings.effects
        self.pose = pose
        self.arm = Arm(
            with_effects(arm, effects, places),
            places,
            pose,
            1.0 / rate_hz,
            settings.gears,
            effects,
            settings.uptime_s,
            SpindleProcess(settings.process, 1.0 / rate_hz) if settings.process.active else None,
        )
        self._delay = _command_delay(effects, rate_hz, pose)
        self._errors = SensorErrors(effects, channels, rate_hz, self._gain * self.arm.at_rest())
        self.sensors = SensorArray(
            settings.sensors,
            len(channels),
            settings.sample_rate_hz,
            np.random.default_rng(settings.seed),
            np.array([channel.unit == ANGULAR_VELOCITY for channel in channels], dtype=bool),
        )
        self._block_samples = settings.block_samples
        self._waiting: list[tuple[Array, Array, Array]] = []
        self._n_waiting = 0
        # Sensors that are late by nature: the first samples are of before the beginning.
        self._n_done = -self._errors.lead_steps

    @property
    def model(self) -> FlexibleJointModel:
        """The arm as it is, effects included."""
        return self.arm.model

    def take(self, motion: tuple[Array, Array, Array]) -> list[SensorBlock]:
        """Take the motor motion of a cycle and return the blocks it completes."""
        if self._delay is not None:
            joined = self._delay.push(np.hstack(motion))
            motion = tuple(np.split(joined, 3, axis=1))  # type: ignore[assignment]
        self._waiting.append(motion)
        self._n_waiting += len(motion[0])
        blocks = []
        while self._n_waiting >= self._block_samples:
            q, qd, qdd = (np.concatenate(parts) for parts in zip(*self._waiting, strict=True))
            count = self._block_samples
            self._waiting = [(q[count:], qd[count:], qdd[count:])]
            self._n_waiting -= count
            done = self.arm.advance(q[:count], qd[:count], qdd[:count])
            self.pose = q[count - 1]
            samples = self.sensors.sample(self._errors.apply(self._gain * done.readings))
            first, self._n_done = self._n_done, self._n_done + count
            early = max(-first, 0)
            if early < count and not self.sensors.loses_block():
                blocks.append(SensorBlock(first + early, samples[early:]))
        return blocks


def _misplaced(
    channels: Sequence[Channel], size: float, random: np.random.Generator
) -> tuple[Channel, ...]:
    """Return the channels with every sensor a little off its place."""
    off: dict[str, Array] = {}
    found = []
    for channel in channels:
        sensor = channel.name.split('.')[0]
        if sensor not in off:
            off[sensor] = size * PLACE_SIGMA_M * random.standard_normal(3)
        x, y, z = (np.array(channel.position_m) + off[sensor]).tolist()
        found.append(replace(channel, position_m=(x, y, z)))
    return tuple(found)


def _command_delay(effects: Sequence[ArmEffect], rate_hz: float, pose: Array) -> DelayLine | None:
    steps = rate_hz * sum(e.number('delay') for e in effects if e.type == 'command_delay')
    if steps == 0.0:
        return None
    if steps < 1.0:
        raise SettingsError(
            'too short', where='command_delay', found=f'{steps / rate_hz:g} s',
            expected=f'>= {1.0 / rate_hz:.2g} s, one sample',
        )  # fmt: skip
    still = np.zeros_like(pose)
    return DelayLine(steps, np.concatenate([pose, still, still]))
