"""The demonstration of milling: the emulated arm cuts while it is identified, and what is true."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rich.table import Table

from abb_emulator.cell import ArmSide, CellSettings
from abb_emulator.process import ProcessLine, ProcessSettings, speed_message
from abb_emulator.recorder import Recorder
from abb_emulator.run_plan import BLOCK_TOPIC, START_NS
from autonomous_modal_analysis.console.terminal import OUTPUT, ProgressCallback, StageCallback
from autonomous_modal_analysis.demos.methods_beside import (
    every_method,
    MethodBeside,
    METHODS_PAGE,
    show_methods,
    write_methods,
)
from autonomous_modal_analysis.identified.identification import (
    IdentifiedRecording,
    identify_recording,
)
from autonomous_modal_analysis.report import match_truth, TrueMode
from autonomous_modal_analysis.views.output import save_results, show_written
from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_core.mode import ModeSet
from modal_dashboard.arm_drawing import draw_arm
from modal_recordings.containers import RecordingWriter
from modal_recordings.messages import encode
from modal_recordings.open_recording import open_recording
from modal_reports import DAMPING, FREQUENCY
from oma_identifier.settings import IdentificationSettings
from structural_model import DampedModes
from structural_model.robot_files import load_layout, load_robot
from structural_model.robot_writer import robot_content

RATE_HZ = 512.0
DURATION_S = 120.0
HIGHEST_HZ = 60.0
"""Below, every mode of the arm is asked for; of those above the report shows what was found."""
FEWEST_DECAYS = 2.0
"""ζ f T that a mode has at least that is asked for; chosen."""
SECOND = round(RATE_HZ)
SHARES = np.array([0.04, 0.48])
"""Of the time of all work: recording took 12 s of 315, identifying 153, and methods the rest."""
READING = 0.05
"""Of the time of identifying: then the record is identified as a whole, which tells nothing."""
CUT = ProcessSettings(
    speed_rpm=1560.0,
    unbalance_g_mm=300.0,
    bearing_orders=(0.4, 3.05, 0.0),
    bearing_n=8.0,
    n_teeth=2,
    depth_mm=0.3,
    feed_mm=0.03,
    runout_um=8.0,
    regeneration=False,
    background_n=12.0,
)
"""Small cutter in aluminium: tooth passing at 52 Hz and the spindle at 26 Hz lie among the modes.
The cut does not act back, so that the modes are those of the arm."""


@dataclass(frozen=True, slots=True)
class MillingDemo:
    """What the demonstration found.

    Parameters
    ----------
    found : IdentifiedRecording
    truth : tuple of TrueMode
        Modes of the arm below ``HIGHEST_HZ`` of ``FEWEST_DECAYS`` or more in the record.
    lines : tuple of ProcessLine
        Lines of the process, by name.
    speed_rpm : float [rpm]
        At the beginning.
    above_db : dict of str to float [dB]
        How far each line stands above the response around it, in the strongest channel.
    arm_hz, arm_width : (n_modes,) array [Hz], [-]
        All modes of the arm, and their half-power half-widths: what lies there is no line.
    beside : tuple of MethodBeside
        Every method on the same samples.
    """

    found: IdentifiedRecording
    truth: tuple[TrueMode, ...]
    lines: tuple[ProcessLine, ...]
    speed_rpm: float
    above_db: dict[str, float]
    arm_hz: NDArray[np.float64]
    arm_width: NDArray[np.float64]
    beside: tuple[MethodBeside, ...] = ()

    @property
    def missed_hz(self) -> list[float]:
        """True modes that were not found [Hz]."""
        return [each.frequency_hz for each in self.truth if each.mode is None]

    @property
    def lines_as_modes_hz(self) -> list[float]:
        """Modes found where the process has a line and the arm has none [Hz]."""
        own = [each.mode.id for each in self.truth if each.mode is not None]
        at = np.array([line.order * self.speed_rpm / 60.0 for line in self.lines])
        return [
            mode.frequency_hz
            for mode in self.found.identification.modes
            if mode.id not in own
            and (np.abs(mode.frequency_hz / at - 1.0) < 2e-3).any()
            and not (np.abs(mode.frequency_hz / self.arm_hz - 1.0) < self.arm_width).any()
        ]


def milling_demo(
    folder: Path,
    robot: str,
    pose: str,
    seed: int,
    progress: StageCallback,
    process: ProcessSettings = CUT,
    every: bool = True,
) -> MillingDemo:
    """Let the arm mill at rest in a pose, record it, identify it, and compare with the truth.

    Parameters
    ----------
    folder : path
        For recording, results and report; made when missing.
    robot, pose : str
        Of config/robots, and a named pose.
    seed : int
        Of chips and sensors.
    progress : callable
        Takes the fraction done, and what is being done.
    process : ProcessSettings
        What the spindle does.
    every : bool
        Ask every method, which takes minutes, and write a page of them.
    """
    model, layout = load_robot(robot), load_layout(robot)
    angles = model.pose(pose)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / 'milling.mcap'
    settings = CellSettings(sample_rate_hz=RATE_HZ, seed=seed, process=replace(process, seed=seed))
    recorder = Recorder.of(layout)
    arm = ArmSide(model, recorder.channels, np.degrees(model.to_controller(angles)), settings)
    recorded, identified = np.cumsum(SHARES if every else SHARES / SHARES.sum())
    _record(
        path, robot_content(model, layout), arm, recorder, angles,
        lambda part: progress(recorded * part, 'cutting'),
    )  # fmt: skip
    recording = open_recording(path, topics=(BLOCK_TOPIC,))
    found = identify_recording(
        recording,
        IdentificationSettings(),
        layout,
        lambda part: progress(
            recorded + (identified - recorded) * (READING * part if part < 1.0 else 1.0),
            'identifying',
        ),
    )
    modes = found.identification.modes
    true = arm.model.damped_modes(angles, layout.channels)
    matched = _matched(modes, true, [channel.name for channel in layout.channels])
    asked = (true.frequency_hz < HIGHEST_HZ) & (
        true.damping_ratio * true.frequency_hz * DURATION_S > FEWEST_DECAYS
    )
    truth = tuple(each for each, wanted in zip(matched, asked, strict=True) if wanted)
    shown = tuple(
        each
        for each, wanted in zip(matched, asked, strict=True)
        if wanted or each.mode is not None
    )
    assert arm.arm.process is not None  # noqa: S101  the spindle turns
    lines = arm.arm.process.lines
    save_results(
        folder,
        found,
        path.name,
        title=f'The emulated {robot} identified while it mills',
        truth=shown,
        placed=draw_arm(model, angles, layout, modes).placed,
        provenance={
            'seed': str(seed),
            'pose': pose,
            **{
                f'line: {line.name}': f'{line.order * process.speed_rpm / 60.0:.2f} Hz'
                for line in lines
            },
        },
    )
    above_db = _above_db(path, lines, process)
    beside: tuple[MethodBeside, ...] = ()
    if every:
        lines_hz = _at_hz(lines, process.speed_rpm)
        beside = every_method(
            found,
            truth,
            true.frequency_hz,
            lines_hz,
            lambda part, method: progress(identified + (1.0 - identified) * part, method),
        )
        write_methods(folder / METHODS_PAGE, truth, beside)
    return MillingDemo(
        found,
        truth,
        lines,
        process.speed_rpm,
        above_db,
        true.frequency_hz,
        true.damping_ratio,
        beside,
    )


def show_milling_demo(demo: MillingDemo, folder: Path) -> None:
    """Print modes beside the truth, and the lines of the process beside what was taken for one."""
    table = Table(title='the milling arm: true and found', title_justify='left')
    for heading in ('true Hz', 'found', 'error %', 'true ζ %', 'found', 'MAC'):
        table.add_column(heading, justify='right')
    for true in demo.truth:
        mode = true.mode
        if mode is None:
            table.add_row(f'{true.frequency_hz:.3f}', 'missed', '', '', '', '')
            continue
        table.add_row(
            f'{true.frequency_hz:.3f}',
            FREQUENCY.number(mode.frequency_hz, mode.frequency_std_hz),
            f'{100.0 * true.frequency_error:+.2f}',
            f'{100.0 * true.damping_ratio:.2f}',
            DAMPING.number(mode.damping_ratio, mode.damping_ratio_std),
            f'{true.mac:.3f}',
        )
    OUTPUT.print(table)
    known = [line.frequency_hz for line in demo.found.identification.harmonics]
    for line in demo.lines:
        at = line.order * demo.speed_rpm / 60.0
        seen = any(abs(each / at - 1.0) < 2e-3 for each in known)
        said = 'marked as a line' if seen else 'not listed'
        OUTPUT.print(
            f'{line.name} at {at:.2f} Hz, {demo.above_db[line.name]:.0f} dB above: {said}'
        )
    for each in demo.lines_as_modes_hz:
        OUTPUT.print(f'a line was taken for a mode: {each:.2f} Hz')
    show_written(folder)
    if demo.beside:
        show_methods(demo.beside, len(demo.truth))
        show_written(folder, (METHODS_PAGE,))


def _at_hz(lines: tuple[ProcessLine, ...], speed_rpm: float) -> NDArray[np.float64]:
    return np.array([line.order * speed_rpm / 60.0 for line in lines])


def _record(
    path: Path,
    attached: Mapping[str, bytes],
    arm: ArmSide,
    recorder: Recorder,
    angles: NDArray[np.float64],
    progress: ProgressCallback,
) -> None:
    """Record the arm standing in its pose, second by second."""
    still = np.zeros((SECOND, len(angles)))
    motion = (np.tile(angles, (SECOND, 1)), still, still)
    process = arm.arm.process
    assert process is not None  # noqa: S101  the spindle turns
    with RecordingWriter(path, attached=attached) as writer:
        for second in range(round(DURATION_S)):
            now_ns = START_NS + second * NANOSECONDS_PER_SECOND
            speed = speed_message(float(process.speed_rpm(float(second))), now_ns)
            writer.write(speed.topic, speed.message_type, speed.log_time_ns, speed.data)
            for block in arm.take(motion):
                for topic, measured in recorder.measurements(
                    BLOCK_TOPIC, block.first_index, block.acceleration, RATE_HZ, START_NS
                ):
                    for item in encode(measured, topic):
                        writer.write(item.topic, item.message_type, item.log_time_ns, item.data)
            progress((second + 1) / DURATION_S)


def _matched(modes: ModeSet, true: DampedModes, names: list[str]) -> tuple[TrueMode, ...]:
    """Return all modes of the arm, with what was found of them."""
    rows = [names.index(name) for name in modes.channel_names]
    shapes = true.channel_shapes[rows] if len(modes) else None
    return match_truth(modes, true.frequency_hz, true.damping_ratio, shapes)


def _above_db(
    path: Path, lines: tuple[ProcessLine, ...], process: ProcessSettings
) -> dict[str, float]:
    """Return how far lines stand above the response around them, (dB), by name."""
    from autonomous_modal_analysis.api.recording import open_recording as open_to_read

    samples = open_to_read(path).samples
    data = samples.acceleration - samples.acceleration.mean(axis=0)
    power = np.abs(np.fft.rfft(data * np.hanning(len(data))[:, None], axis=0)) ** 2
    step_hz = samples.sample_rate_hz / len(data)
    found = {}
    for line in lines:
        at = round(line.order * process.speed_rpm / 60.0 / step_hz)
        around = np.r_[at - 60 : at - 12, at + 13 : at + 61]
        peak = power[at - 2 : at + 3].max(axis=0)
        found[line.name] = float(10.0 * np.log10(np.max(peak / np.median(power[around], axis=0))))
    return found
