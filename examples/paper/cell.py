"""The chain every finding goes through: plan, controller, drives, arm, sensors, identifier.

The parts are the emulated cell's own, advanced cycle by cycle without sockets or clock, so a
minute of shaking takes seconds.
"""

from dataclasses import dataclass
from itertools import chain

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from abb_emulator.cell import ArmSide, CellSettings, MotorSide
from abb_emulator.sensing import SensorSettings
from excitation_planner.plan import ExcitationPlan
from excitation_planner.planner import plan_excitation
from excitation_planner.pose_range.sensitivity import actual_change
from excitation_planner.request import PlanRequest
from excitation_planner.signals import BAND_LIMITED_NOISE, RANDOM_PULSES
from modal_core.channel import Channel
from modal_core.measurements import (
    JointSamples,
    Measurement,
    NANOSECONDS_PER_SECOND,
    SampleBlock,
)
from modal_core.mode import Mode
from modal_core.numbers.indicators import mac
from oma_identifier.pipeline import IdentificationPipeline
from oma_identifier.result import WindowResult
from oma_identifier.settings import IdentificationSettings
from robot_bridge.player import PlanPath
from structural_model import load_layout, load_robot
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]
ROBOT = 'irb6660_205_190'
# Where modes are looked for: the planner's own band.
LOWEST_HZ, HIGHEST_HZ = 5.0, 60.0
SAMPLE_RATE_HZ = 512.0
# As long as the emulated cell's blocks at its own rate: how often the arm's dynamics follow the
# pose.
BLOCK_SAMPLES = 16
NOISE_DENSITY = 3e-4
CYCLES_PER_MESSAGE = 25
# Point-to-point moves of constant acceleration with pauses of 0 to 1 s, as the paper describes
# them.  What a spline through 4 ms samples makes of the steps overshoots by a third; 0.7 keeps
# that below the limit.  The paper names no speed limit, so the planner's 250 mm/s are lifted.
AS_IN_THE_PAPER = {
    'signal': RANDOM_PULSES,
    'acceleration_low': 0.7,
    'acceleration_high': 0.7,
    'ramp_low_s': 0.0,
    'ramp_high_s': 0.0,
    'speed_low': 1.0,
    'speed_high': 1.0,
    'interval_low_s': 0.0,
    'interval_high_s': 1.0,
    'point_speed_m_s': 5.0,
    'enforce_tolerance': False,
    'require_full_rank': False,
}
# Shaking that leaves the arm in its posture: noise of some hundredths of a degree, the axes as
# strong as modes and torques need, which is the planner's own choice.
STILL_NOISE = {
    'signal': BAND_LIMITED_NOISE,
    'point_speed_m_s': 0.25,
    'band_low_hz': 8.0,
    'require_full_rank': True,
}
SAME_FREQUENCY = 0.08
SAME_MAC = 0.6


class PlannedMoves:
    """The controller's own moves along a plan, one step per cycle."""

    def __init__(self, path: PlanPath, cycle_s: float) -> None:
        self._path, self._cycle_s, self._time_s = path, cycle_s, 0.0

    def step(self) -> Array:
        """Return the angles at the end of the next cycle [deg]."""
        self._time_s += self._cycle_s
        return self._path.position(self._time_s)

    @property
    def finished(self) -> bool:
        """The plan has been played."""
        return self._time_s >= self._path.duration_s


@dataclass(frozen=True)
class Record:
    """What one run of the cell left behind."""

    plan: ExcitationPlan
    measurements: tuple[Measurement, ...]

    @property
    def acceleration(self) -> Array:
        """What the sensors recorded, (n_samples, n_channels) [m/s²]."""
        blocks = [part for part in self.measurements if isinstance(part, SampleBlock)]
        return np.concatenate([block.acceleration for block in blocks]).astype(float)

    @property
    def position(self) -> Array:
        """Encoder angles of the serial joints, one row per controller cycle [rad]."""
        parts = [part for part in self.measurements if isinstance(part, JointSamples)]
        return np.concatenate([part.position for part in parts])


@dataclass(frozen=True)
class Truth:
    """The emulated arm's modes: at the centre of the motion, and over its poses."""

    frequency_hz: Array
    damping_ratio: Array
    channel_shapes: NDArray[np.complex128]
    over_path_hz: Array

    @property
    def mean_hz(self) -> Array:
        """Natural frequencies, mean over the path [Hz]."""
        return self.over_path_hz.mean(axis=0)


def robot() -> FlexibleJointModel:
    return load_robot(ROBOT)


def plan_pulses(
    model: FlexibleJointModel,
    pose: str,
    low_deg: float,
    high_deg: float,
    seed: int,
    duration_s: float,
    **changes: object,
) -> ExcitationPlan:
    """Plan pulses of all controller axes from ``pose + low`` to ``pose + high``."""
    centre = model.to_controller(model.pose(pose)) + np.deg2rad(0.5 * (low_deg + high_deg))
    fields = {**AS_IN_THE_PAPER, **changes}
    request = PlanRequest.from_mapping(
        {
            'seed': seed,
            'start_position': [float(angle) for angle in model.to_serial(centre)],
            'duration_s': duration_s,
            'half_range': float(np.deg2rad(0.5 * (high_deg - low_deg))),
            'noise_density': NOISE_DENSITY,
            **fields,
        }
    )
    return plan_excitation(model, load_layout(ROBOT), request)


def shake(
    model: FlexibleJointModel,
    plan: ExcitationPlan,
    seed: int,
    noise_density: float = NOISE_DENSITY,
    channels: tuple[Channel, ...] | None = None,
) -> Record:
    """Let the emulated cell play a plan; the seed draws noise and bias of its sensors.

    The sensors are those of the robot's layout, unless ``channels`` are given.
    """
    cell = CellSettings(
        sample_rate_hz=SAMPLE_RATE_HZ,
        block_samples=BLOCK_SAMPLES,
        seed=seed,
        sensors=SensorSettings(noise_density=noise_density),
    )
    channels = channels or load_layout(ROBOT).channels
    names = tuple(channel.name for channel in channels)
    start_deg = np.degrees(model.to_controller(plan.start_position))
    motor = MotorSide(model, start_deg, None, cell, start_time_s=0.0)
    arm = ArmSide(model, channels, start_deg, cell)
    cycle_s = cell.controller.cycle_s
    path = PlanPath.from_trajectory(plan.plan_hash, plan.trajectory, model.to_controller)
    motor.controller.motion = PlannedMoves(path, cycle_s)
    measurements: list[Measurement] = []
    angles_deg: list[Array] = []
    cycle = 0
    while motor.controller.motion is not None:
        cycle += 1
        for block in arm.take(motor.cycle()):
            stamp_ns = round(block.first_index / SAMPLE_RATE_HZ * NANOSECONDS_PER_SECOND)
            measurements.append(
                SampleBlock(
                    'cell', stamp_ns, block.first_index, SAMPLE_RATE_HZ, names, block.acceleration
                )
            )
        angles_deg.append(motor.controller.measured_deg)
        if len(angles_deg) == CYCLES_PER_MESSAGE or motor.controller.motion is None:
            measurements.append(_joints(model, np.array(angles_deg), cycle, cycle_s))
            angles_deg = []
    if motor.controller.events:
        raise RuntimeError(f'the controller stopped: {motor.controller.events}')
    return Record(plan, tuple(measurements))


def settings(record: Record, max_order: int = 60) -> IdentificationSettings:
    """Return the identifier's settings: one window, the planner's band, defaults elsewhere."""
    return IdentificationSettings(
        window_s=np.floor(record.plan.duration_s),
        min_frequency_hz=LOWEST_HZ,
        max_frequency_hz=HIGHEST_HZ,
        max_order=max_order,
    )


def identify(record: Record, max_order: int = 60) -> WindowResult:
    """Identify a record as one window, through the pipeline of node and command line.

    From the accelerometers alone, as in the paper: given joint states without a robot model, the
    identifier reports no mode that motion this wide might explain.
    """
    pipeline = IdentificationPipeline(settings(record, max_order), load_layout(ROBOT))
    for measurement in record.measurements:
        if isinstance(measurement, SampleBlock):
            pipeline.add(measurement)
    return pipeline.identify(next(chain(pipeline.windows(), pipeline.finish())))


def truth(
    model: FlexibleJointModel,
    record: Record,
    n_poses: int = 200,
    channels: tuple[Channel, ...] | None = None,
) -> Truth:
    """Return the modes at the centre and, followed by shape, over the poses of the path."""
    centre = record.plan.start_position
    modes = model.damped_modes(centre, channels or load_layout(ROBOT).channels)
    change = actual_change(model, centre, HIGHEST_HZ)
    rows = np.linspace(0, len(record.position) - 1, n_poses).round().astype(int)
    n_modes = int(np.sum(model.modes(centre).frequency_hz <= HIGHEST_HZ))
    frequency_hz = model.modes(centre).frequency_hz[:n_modes]
    over_path = np.array([frequency_hz * (1.0 + change(record.position[row])) for row in rows])
    return Truth(
        frequency_hz=modes.frequency_hz[:n_modes],
        damping_ratio=modes.damping_ratio[:n_modes],
        channel_shapes=modes.channel_shapes[:, :n_modes],
        over_path_hz=over_path,
    )


def matched(modes: tuple[Mode, ...], real: Truth) -> dict[int, Mode]:
    """Return the identified mode of each true mode: alike in shape and near in frequency."""
    if not modes:
        return {}
    found_hz = np.array([mode.frequency_hz for mode in modes])
    shapes = np.column_stack([mode.shape for mode in modes])
    likeness = mac(real.channel_shapes, shapes)
    near = np.abs(found_hz / real.mean_hz[:, None] - 1.0) < SAME_FREQUENCY
    score = np.where(near & (likeness > SAME_MAC), likeness, 0.0)
    rows, columns = linear_sum_assignment(-score)
    return {
        int(row): modes[column]
        for row, column in zip(rows, columns, strict=True)
        if score[row, column] > 0.0
    }


def _joints(
    model: FlexibleJointModel, angles_deg: Array, last_cycle: int, cycle_s: float
) -> JointSamples:
    cycles = last_cycle + 1 - len(angles_deg) + np.arange(len(angles_deg))
    position = model.to_serial(np.radians(angles_deg))
    return JointSamples(
        stamp_ns=np.round(cycles * cycle_s * NANOSECONDS_PER_SECOND).astype(np.int64),
        joint_names=model.joint_names,
        position=position,
        velocity=np.full_like(position, np.nan),
    )
