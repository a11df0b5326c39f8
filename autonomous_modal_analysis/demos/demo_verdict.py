"""What the demo found beside what is true, and whether that is good enough."""

from dataclasses import dataclass, replace
import math

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.table import Table

from autonomous_modal_analysis.console.terminal import MESSAGES, OUTPUT
from autonomous_modal_analysis.demos.demonstration import DemoRun, DemoSettings
from autonomous_modal_analysis.identified.identification import (
    IdentifiedRecording,
    identify_recording,
)
from autonomous_modal_analysis.report import match_truth, TrueMode
from autonomous_modal_analysis.views.output import save_results, show_written
from modal_core.mode import ModeSet
from modal_dashboard.arm_drawing import draw_arm
from modal_recordings.open_recording import open_recording
from modal_reports import DAMPING, fixed, FREQUENCY, percent
from oma_identifier.settings import IdentificationSettings
from structural_model.robot_files import load_layout, load_robot

LARGEST_ERROR = 0.01
LARGEST_ERROR_SIGMA = 3.0
HEADINGS = ('true Hz', 'found Hz', 'error', '/σ', 'true %', 'found %', '/σ', 'MAC', 'live')


@dataclass(frozen=True, slots=True)
class ComparedMode:
    """One true mode, what was found of it, and how often the live node saw it.

    Parameters
    ----------
    true : TrueMode
        With its identified counterpart, from the whole recording where that shows it.
    in_band : bool
        Inside the band the plan excites.
    n_live : int
        Live windows with a mode within 5 % of its frequency.
    """

    true: TrueMode
    in_band: bool
    n_live: int

    @property
    def failure(self) -> str:
        """Why it does not pass; empty when it does or need not."""
        if not self.in_band:
            return ''
        name = f'{self.true.frequency_hz:.2f} Hz'
        if self.true.mode is None:
            return f'the mode at {name} was missed'
        if self.n_live == 0:
            return f'the live node never saw the mode at {name}'
        error, sigma = abs(self.true.frequency_error), abs(self.true.frequency_error_sigma)
        if error > LARGEST_ERROR and (sigma > LARGEST_ERROR_SIGMA or math.isnan(sigma)):
            return f'the mode at {name} is off by {100 * error:.1f} %, {sigma:.1f} σ'
        return ''


@dataclass(frozen=True, slots=True)
class DemoVerdict:
    """The demo's verdict.

    Parameters
    ----------
    modes : tuple of ComparedMode
        True modes by frequency.
    n_windows : int
        Live windows.
    band_hz : (low, high) tuple [Hz]
        Excited band.
    """

    modes: tuple[ComparedMode, ...]
    n_windows: int
    band_hz: tuple[float, float]

    @property
    def failures(self) -> tuple[str, ...]:
        """What is wrong, one line each."""
        return tuple(mode.failure for mode in self.modes if mode.failure)


def judge_demo(settings: DemoSettings, run: DemoRun) -> DemoVerdict:
    """Identify the demo's recording, compare with the truth and write results and report."""
    model = load_robot(settings.robot)
    layout = load_layout(settings.robot)
    found = identify_recording(
        open_recording(settings.recording, topics=('/acceleration_block', '/joint_states')),
        IdentificationSettings(
            window_s=settings.window_s,
            hop_s=settings.hop_s,
        ),
        layout,
    )
    truth = _matched(found.identification.modes, run)
    modes = tuple(
        ComparedMode(
            true=true if true.mode is not None else _from_windows(found, run, place),
            in_band=run.band_hz[0] <= true.frequency_hz <= run.band_hz[1],
            n_live=sum(
                bool(np.any(np.abs(seen / true.frequency_hz - 1.0) < 0.05))
                for seen in run.window_frequencies_hz
            ),
        )
        for place, true in enumerate(truth)
    )
    drawing = draw_arm(model, run.truth.position, layout, found.identification.modes)
    save_results(
        settings.folder,
        found,
        settings.recording.name,
        title=f'Self-excited modal analysis of the emulated {settings.robot}',
        truth=tuple(mode.true for mode in modes if mode.in_band or mode.true.mode is not None),
        placed=drawing.placed,
        provenance={'plan': run.plan_hash, 'seed': str(settings.seed), 'pose': settings.pose},
    )
    show_written(settings.folder)
    return DemoVerdict(modes=modes, n_windows=len(run.window_frequencies_hz), band_hz=run.band_hz)


def show_verdict(verdict: DemoVerdict) -> None:
    """Print true against identified modes, for people."""
    low, high = verdict.band_hz
    table = Table(
        title=f'modes in the excited band, {low:.1f} to {high:.1f} Hz:'
        ' natural frequency and damping ratio, true and found ± σ;'
        ' live: windows of the live node that show the mode',
        title_justify='left',
        box=SIMPLE_HEAD,
        padding=(0, 0),
    )
    for heading in HEADINGS:
        table.add_column(heading, justify='right', no_wrap=True)
    for mode in verdict.modes:
        if mode.in_band:
            table.add_row(*_row(mode, verdict.n_windows))
    OUTPUT.print(table)
    for mode in verdict.modes:
        if mode.in_band and mode.true.from_window:
            MESSAGES.print(
                f'note: {mode.true.frequency_hz:.2f} Hz is from a single window,'
                ' the whole recording does not show it'
            )
    for failure in verdict.failures:
        MESSAGES.print(f'[bold red]failed[/]: {failure}')
    if not verdict.failures:
        OUTPUT.print('every mode in the excited band was found')


def _row(mode: ComparedMode, n_windows: int) -> tuple[str, ...]:
    true, found = mode.true, mode.true.mode
    live = f'{mode.n_live}/{n_windows}'
    if found is None:
        truth = (f'{true.frequency_hz:.2f}', 'missed', '', '', f'{100 * true.damping_ratio:.2f}')
        return (*truth, '', '', '', live)
    return (
        f'{true.frequency_hz:.2f}',
        FREQUENCY.number(found.frequency_hz, found.frequency_std_hz),
        percent(true.frequency_error, 2, sign=True),
        fixed(true.frequency_error_sigma, 1, sign=True),
        f'{100 * true.damping_ratio:.2f}',
        DAMPING.number(found.damping_ratio, found.damping_ratio_std),
        fixed(true.damping_error_sigma, 1, sign=True),
        fixed(true.mac, 3),
        live,
    )


def _from_windows(found: IdentifiedRecording, run: DemoRun, place: int) -> TrueMode:
    """Return a mode the whole recording does not show as the newest window that does shows it."""
    newest_first = reversed(found.identification.windows)
    seen = (_matched(window.modes, run)[place] for window in newest_first)
    missed = _matched(ModeSet((), run.truth.channel_names), run)[place]
    shown = next((true for true in seen if true.mode is not None), None)
    return missed if shown is None else replace(shown, from_window=True)


def _matched(modes: ModeSet, run: DemoRun) -> tuple[TrueMode, ...]:
    """Pair true and identified modes at the channels both know."""
    rows = [run.truth.channel_names.index(name) for name in modes.channel_names]
    return match_truth(
        modes, run.truth.frequency_hz, run.truth.damping_ratio, run.truth.shapes[rows]
    )
