"""Play a plan on the emulated cell as fast as it goes, and record what a real one would record.

No clock, no network, no ROS: controller, drives, arm and sensors are stepped cycle by cycle.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abb_emulator.cell import ArmSide, CellSettings, MotorSide, PARTS
from abb_emulator.controller import Controller, Program
from abb_emulator.egm import GuidanceLaw, GuidanceSettings
from abb_emulator.mechanics import ArmEffect, read_effects
from abb_emulator.process import speed_message
from abb_emulator.rapid import ProgramTask
from abb_emulator.recorder import Recorder
from excitation_planner.plan import ExcitationPlan
from excitation_planner.rapid import rapid_module
from excitation_planner.signals import MOVES
from modal_core.channel import SensorLayout
from modal_core.errors import BridgeError
from modal_core.measurements import (
    JointSamples,
    Measurement,
    NANOSECONDS_PER_SECOND,
)
from modal_core.settings.near_names import refuse_unknown
from modal_core.settings.schema import read_values, setting, settings_of
from modal_core.work.progress import Progress
from modal_recordings.containers import RecordingWriter
from modal_recordings.messages import encode, RawMessage
from robot_bridge.player import PlanPath, PlanPlayer, PlayerSettings
from structural_model.flexible_joint_model import FlexibleJointModel
from structural_model.robot_files import load_layout, load_robot
from structural_model.robot_writer import robot_content

Array = NDArray[np.float64]
START_NS = 1_700_000_000_000_000_000
BLOCK_TOPIC, JOINT_TOPIC = '/acceleration_block', '/joint_states'
# As an exported program sets guidance up.
GUIDANCE = GuidanceSettings(
    low_pass_hz=100.0, max_speed_deviation_deg_s=100.0, condition_time_s=math.inf
)


@dataclass(frozen=True, slots=True)
class ArmOptions:
    """The cell a plan is played on.

    Parameters
    ----------
    robot : str
        Robot of config/robots, its folder, or its model file.
    sensors_file : str
        Sensor layout of the robot.
    cell : CellSettings
        Its sampling, drives, sensors, seeds, effects and tolerances.
    guidance : GuidanceSettings
        For plans that are played by guidance.
    rest_s : float [s]
        Recorded at rest before and after the motion.
    """

    robot: str = setting('irb6660_205_190', 'robot of config/robots, its folder or model file')
    sensors_file: str = setting('sensors', 'sensor layout of the robot')
    cell: CellSettings = field(default_factory=CellSettings)
    guidance: GuidanceSettings = GUIDANCE
    rest_s: float = setting(1.0, 'recorded at rest before and after [s]', 0.0, 86400.0)

    def with_effects(self, *effects: ArmEffect) -> 'ArmOptions':
        """Return the same cell with these effects instead."""
        return replace(self, cell=replace(self.cell, effects=effects))

    @classmethod
    def from_mapping(cls, data: Mapping[str, object]) -> 'ArmOptions':
        """Read options as YAML holds them.

        ``robot``, ``sensors_file``, ``rest_s``; ``sample_rate_hz``, ``block_samples``, ``seed``,
        ``tolerance``, ``tolerance_seed``, ``uptime_s``; ``effects`` as a list; ``servo``,
        ``gears``, ``sensors``, ``controller``, ``process`` and ``guidance`` as mappings.

        Raises
        ------
        SettingsError
            Unknown, or of the wrong kind.
        """
        own, cell = ([item.name for item in settings_of(kind)] for kind in (cls, CellSettings))
        parts = {**PARTS, 'guidance': GuidanceSettings}
        refuse_unknown(data, (*own, *cell, 'effects', *parts), 'unknown option', 'arm')
        given = {
            part: read_values(kind, data[part], f'arm: {part}', f'arm: {part}.')
            for part, kind in parts.items()
            if part in data
        }

        def flat(kind: type, names: Sequence[str]) -> dict[str, Any]:
            return read_values(kind, {n: data[n] for n in names if n in data}, group='arm: ')

        return cls(
            guidance=replace(GUIDANCE, **given.pop('guidance', {})),
            cell=CellSettings(
                effects=read_effects(data['effects']) if 'effects' in data else (),
                **{part: PARTS[part](**values) for part, values in given.items()},
                **flat(CellSettings, cell),
            ),
            **flat(cls, own),
        )


@dataclass(frozen=True, slots=True)
class PlanRun:
    """What playing a plan left behind.

    Parameters
    ----------
    path : Path
        The recording.
    duration_s : float [s]
        Recorded.
    events : tuple of str
        What the controller noted.
    """

    path: Path
    duration_s: float
    events: tuple[str, ...]


def run_plan(
    options: ArmOptions,
    plan: ExcitationPlan,
    path: Path,
    progress: Progress = lambda _: None,
    first: Sequence[RawMessage] = (),
) -> PlanRun:
    """Play a plan on an emulated cell and record it.

    Random pulses run as the RAPID program exported for them, band-limited noise by guidance, both
    through the controller's own planner or control law, dead time and servo.  The recording holds
    ``/acceleration_block`` (AccelerationBlock), ``/joint_states`` (one JointState per controller
    cycle, encoder angles as serial joints) and the topics of IMUs in the layout; it carries the
    robot as it is known, without what is hidden in its arm, and the layout.

    Parameters
    ----------
    options : ArmOptions
        The cell, with what is hidden in its arm.
    plan : ExcitationPlan
        What to play; it starts at its own start pose.
    path : Path
        MCAP file to write.
    progress : callable
        Takes the fraction done, about once a second of the cell's time.
    first : sequence of RawMessage
        Further messages the recording begins with, such as the plan.

    Raises
    ------
    ModalAnalysisError
        The controller stopped the motion, the file cannot be written, or an option is wrong.
    """
    model = load_robot(options.robot)
    layout = load_layout(options.robot, options.sensors_file)
    duration_s = 0.0
    cell = _Cell(options, model, layout, plan)
    with RecordingWriter(path, attached=robot_content(model, layout)) as writer:
        for item in first:
            writer.write(item.topic, item.message_type, item.log_time_ns, item.data)
        for duration_s, messages in cell.seconds():
            for item in cell.spindle(duration_s):
                writer.write(item.topic, item.message_type, item.log_time_ns, item.data)
            for topic, measurement in messages:
                for item in encode(measurement, topic):
                    writer.write(item.topic, item.message_type, item.log_time_ns, item.data)
            progress(min(duration_s / (plan.duration_s + 2.0 * options.rest_s), 1.0))
    progress(1.0)
    return PlanRun(path, duration_s, tuple(cell.controller.events))


class PlayedPlan:
    """A plan as guidance plays it: references through the control law.

    Parameters
    ----------
    player : PlanPlayer
        Gives the references.
    law : GuidanceLaw
        Of the session.
    cycle_s : float [s]
        Controller cycle.
    """

    def __init__(self, player: PlanPlayer, law: GuidanceLaw, cycle_s: float) -> None:
        self._player, self._law, self._cycle_s = player, law, cycle_s

    @property
    def finished(self) -> bool:
        """The plan has been played."""
        return self._player.at_rest

    def step(self) -> Array:
        """Return the position at the end of the next cycle, (6,) [deg]."""
        reference = self._player.step(self._cycle_s)
        self._law.refer(reference.position_deg, reference.speed_deg_s)
        return self._law.step()


class _Cell:
    """One run, second by second."""

    def __init__(
        self,
        options: ArmOptions,
        model: FlexibleJointModel,
        layout: SensorLayout,
        plan: ExcitationPlan,
    ) -> None:
        settings = options.cell
        start_deg = np.degrees(model.to_controller(plan.start_position))
        self._options, self._model = options, model
        self._recorder = Recorder.of(layout)
        self._motors = MotorSide(model, start_deg, None, settings, 0.0)
        self._arm = ArmSide(model, self._recorder.channels, start_deg, settings)
        self.controller = self._motors.controller
        self._cycle_s = settings.controller.cycle_s
        self._n_cycles = 0
        self._task = ProgramTask(
            self.controller, options.guidance, np.random.default_rng(settings.seed + 2)
        )
        if plan.signal in MOVES:
            self._task.load(rapid_module(plan, model))
        self._plan = plan

    def spindle(self, time_s: float) -> list[RawMessage]:
        """Return the spindle's speed, where one turns."""
        process = self._arm.arm.process
        if process is None:
            return []
        now_ns = START_NS + round(time_s * NANOSECONDS_PER_SECOND)
        return [speed_message(float(process.speed_rpm(time_s)), now_ns)]

    def seconds(self) -> Iterator[tuple[float, list[tuple[str, Measurement]]]]:
        """Yield the time and what was measured since, in order of time."""
        rest = round(self._options.rest_s / self._cycle_s)
        yield self._some(rest)
        self._start()
        while self.controller.running:
            yield self._some(round(1.0 / self._cycle_s), stop_early=True)
        wrong = [event for event in self.controller.events if 'stopped' in event]
        if wrong:
            raise BridgeError('the emulated controller stopped', found=wrong[-1])
        yield self._some(rest)

    def _start(self) -> None:
        if self._task.module is not None:
            self._task.start()
        else:
            self.controller.start(_played(self.controller, self._model, self._plan, self._options))

    def _some(
        self, n_cycles: int, stop_early: bool = False
    ) -> tuple[float, list[tuple[str, Measurement]]]:
        angles, blocks = [], []
        for _ in range(n_cycles):
            blocks += self._arm.take(self._motors.cycle())
            angles.append(self.controller.axes.measured_deg)
            if stop_early and not self.controller.running:
                break
        first = self._n_cycles
        self._n_cycles += len(angles)
        rate_hz = self._options.cell.sample_rate_hz
        found = [
            item
            for block in blocks
            for item in self._recorder.measurements(
                BLOCK_TOPIC, block.first_index, block.acceleration, rate_hz, START_NS
            )
        ]
        if angles:
            found.append((JOINT_TOPIC, self._joints(np.array(angles), first)))
        return self._n_cycles * self._cycle_s, found

    def _joints(self, angles_deg: Array, first_cycle: int) -> JointSamples:
        times = (first_cycle + 1 + np.arange(len(angles_deg))) * self._cycle_s
        position = self._model.to_serial(np.radians(angles_deg))
        return JointSamples(
            START_NS + np.round(times * NANOSECONDS_PER_SECOND).astype(np.int64),
            self._model.joint_names,
            position,
            np.full_like(position, math.nan),
        )


def _played(
    controller: Controller, model: FlexibleJointModel, plan: ExcitationPlan, options: ArmOptions
) -> Program:
    """Play a plan by guidance, then wait for the motors."""
    path = PlanPath.from_trajectory(plan.plan_hash, plan.trajectory, model.to_controller)
    player = PlanPlayer(path, controller.axes.planned_deg, PlayerSettings())
    cycle_s = controller.settings.cycle_s
    law = GuidanceLaw(options.guidance, controller.axes.planned_deg, cycle_s)
    controller.axes.motion = PlayedPlan(player, law, cycle_s)
    while controller.axes.moving or not controller.axes.standing:
        yield
