"""Controller, drives, arm and sensors together, advanced cycle by cycle; no clock and no ROS."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from modal_core.channel import ANGULAR_VELOCITY, Channel
from robot_bridge.emulator.arm import Arm
from robot_bridge.emulator.controller import Controller, ControllerSettings
from robot_bridge.emulator.gear_torque import GearSettings
from robot_bridge.emulator.sensors import SensorArray, SensorSettings
from robot_bridge.emulator.servo import Servo, ServoSettings
from robot_bridge.emulator.udp_client import UdpClient
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]
PPM = 1e-6


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
    controller, servo, gears, sensors
        Settings of the parts.
    """

    sample_rate_hz: float = 2048.0
    block_samples: int = 64
    seed: int = 1
    controller: ControllerSettings = field(default_factory=ControllerSettings)
    servo: ServoSettings = field(default_factory=ServoSettings)
    gears: GearSettings = field(default_factory=GearSettings)
    sensors: SensorSettings = field(default_factory=SensorSettings)


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
        before = controller.planned_deg
        after = controller.tick()
        begin_s = self._n_cycles * self._cycle_s
        self._n_cycles += 1
        n_end = int(self._n_cycles * self._cycle_s * self.true_rate_hz)
        times = np.arange(self._n_steps + 1, n_end + 1) / self.true_rate_hz
        self._n_steps = n_end
        part = ((times - begin_s) / self._cycle_s)[:, None]
        motion = self._servo.advance(before + part * (after - before))
        controller.measured_deg = self._servo.measured_deg
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
        self.pose = pose
        self.arm = Arm(model, channels, pose, 1.0 / rate_hz, settings.gears)
        self.sensors = SensorArray(
            settings.sensors,
            len(channels),
            settings.sample_rate_hz,
            np.random.default_rng(settings.seed),
            np.array([channel.unit == ANGULAR_VELOCITY for channel in channels], dtype=bool),
        )
        self._block_samples = settings.block_samples
        self._waiting: list[tuple[Array, Array, Array]] = []
        self._n_waiting = self._n_done = 0

    def take(self, motion: tuple[Array, Array, Array]) -> list[SensorBlock]:
        """Take the motor motion of a cycle and return the blocks it completes."""
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
            samples = self.sensors.sample(done.readings)
            if not self.sensors.loses_block():
                blocks.append(SensorBlock(self._n_done, samples))
            self._n_done += count
        return blocks
