"""A tap test of the emulated arm: recordings of taps, their modes, the true ones beside them."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.table import Table

from abb_emulator.hammer import HammerRecord, HammerTaps, tap
from autonomous_modal_analysis.api.impact import impact, TapTest
from autonomous_modal_analysis.console.terminal import OUTPUT
from autonomous_modal_analysis.tap_report import show_tap_test
from modal_core.channel import Channel
from structural_model import DampedModes, load_layout, load_robot

N_POINTS = 3
WITHIN = 0.01
"""A mode of the arm is found when one lies so near: share of its frequency."""
HIGHEST_HZ = 60.0
"""Up to where every mode of the arm is asked for."""


@dataclass(frozen=True, slots=True)
class TapDemo:
    """What the demonstration found.

    Parameters
    ----------
    result : TapTest
    truth : DampedModes
        Of the arm in its pose.
    """

    result: TapTest
    truth: DampedModes

    @property
    def missed_hz(self) -> list[float]:
        """True modes in the band of the demonstration that nothing lies near [Hz]."""
        found = self.result.frequencies_hz
        return [
            float(true_hz)
            for true_hz in self.truth.frequency_hz
            if true_hz < HIGHEST_HZ and not (np.abs(found / true_hz - 1.0) < WITHIN).any()
        ]


def tap_demo(folder: Path, robot: str, pose: str, seed: int) -> TapDemo:
    """Tap three points of the arm, write the recordings, and identify them.

    Parameters
    ----------
    folder : path
        For the recordings and the results; made when missing.
    robot, pose : str
        Of config/robots, and a named pose.
    seed : int
        Of times, sizes and noise.
    """
    model, channels = load_robot(robot), load_layout(robot).channels
    angles, rng = model.pose(pose), np.random.default_rng(seed)
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    for number, hit in enumerate(_points(channels)):
        # The second tap of the first point bounces, as it happens to everyone.
        how = HammerTaps(double=(1,)) if number == 0 else HammerTaps()
        record = tap(model, angles, channels, hit, how, rng)
        files.append(folder / f'taps_{hit.name}.csv')
        _write(files[-1], record)
    result = impact(files)
    result.save(folder)
    return TapDemo(result, model.damped_modes(angles, channels))


def show_tap_demo(demo: TapDemo) -> None:
    """Print the result, and the true modes beside the nearest found."""
    show_tap_test(demo.result.found, demo.result.name)
    table = Table(title='the arm itself', title_justify='left')
    for heading in ('true frequency', 'error %', 'true damping', 'error %'):
        table.add_column(heading, justify='right')
    found = demo.result.modes
    for true_hz, true_zeta in zip(demo.truth.frequency_hz, demo.truth.damping_ratio, strict=True):
        if not len(found) or true_hz > demo.result.found.band_hz[1]:
            break
        mode = found.modes[int(np.argmin(np.abs(found.frequency_hz - true_hz)))]
        near = abs(mode.frequency_hz / true_hz - 1.0) < WITHIN
        table.add_row(
            f'{true_hz:.3f} Hz',
            f'{100.0 * (mode.frequency_hz / true_hz - 1.0):+.3f}' if near else 'missed',
            f'{100.0 * true_zeta:.3f} %',
            f'{100.0 * (mode.damping_ratio / true_zeta - 1.0):+.2f}' if near else '',
        )
    OUTPUT.print(table)


def _points(channels: Sequence[Channel]) -> list[Channel]:
    """Return the last sensor's axes: of the tool, where every mode moves."""
    return list(channels[-N_POINTS:])


def _write(path: Path, record: HammerRecord) -> None:
    samples = record.responses
    time_s = np.arange(len(record.force_n)) / samples.sample_rate_hz
    names = ','.join(f'{name} [m/s^2]' for name in samples.channel_names)
    np.savetxt(
        path,
        np.column_stack([time_s, record.force_n, samples.acceleration]),
        fmt='%.7g',
        delimiter=',',
        header=f'time [s],hammer@{record.hit} [N],{names}',
        comments='',
    )
