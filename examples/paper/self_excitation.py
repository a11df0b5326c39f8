"""Table 8: self-excitation at P1 (+15 deg) and P3 (+5 deg), identified through the whole chain.

Run ``python -m examples.paper.self_excitation``.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
import typer

from examples.paper.cell import (
    identify,
    matched,
    plan_pulses,
    Record,
    robot,
    shake,
    Truth,
    truth,
)
from examples.paper.drawing import COLOURS, GREY, panels, save
from examples.paper.output import (
    Finding,
    PARTLY,
    REPRODUCED,
    say,
    show_findings,
    show_table,
)
from excitation_planner.signals import BAND_LIMITED_NOISE
from modal_core.mode import Mode
from oma_identifier.result import WindowResult

SEED = 2025
DURATION_S = 120.0
SECTION = '5 Self-excitation'
# Pose, and from where to where every axis moves: Table 7 of the paper.
REGIONS = (('P1', 0.0, 15.0), ('P3', 0.0, 5.0))
PUBLISHED_HZ = {'P1': (11.1, 19.4, 29.3, 38.1), 'P3': (10.3, 18.0, 42.8, 50.6)}
# The largest difference to the impact test that the paper puts down to the running joints.
LARGEST_SHIFT_HZ = 2.9


@dataclass(frozen=True, eq=False)
class Case:
    """A way to shake the arm."""

    name: str
    changes: dict[str, object]


AS_PAPER = Case('as in the paper', {})
SLOW = Case('at most 250 mm/s', {'point_speed_m_s': 0.25, 'speed_high': 0.9, 'speed_low': 0.9})
NOISE = Case(
    'band-limited noise, 250 mm/s',
    {'signal': BAND_LIMITED_NOISE, 'point_speed_m_s': 0.25, 'band_low_hz': 8.0},
)


@dataclass(frozen=True)
class Run:
    """One region shaken in one way."""

    pose: str
    span_deg: float
    case: Case
    record: Record
    truth: Truth
    result: WindowResult
    at_start_hz: np.ndarray

    @property
    def pairs(self) -> dict[int, Mode]:
        """Identified mode of each true one."""
        return matched(self.result.modes.modes, self.truth)

    @property
    def extra(self) -> list[Mode]:
        """Identified modes that belong to no true one."""
        real = {id(mode) for mode in self.pairs.values()}
        return [mode for mode in self.result.modes if id(mode) not in real]


@cache
def run(
    pose: str,
    low_deg: float,
    high_deg: float,
    case: Case,
    seed: int = SEED,
    duration_s: float = DURATION_S,
) -> Run:
    """Plan, shake, identify, and work out what is true."""
    model = robot()
    plan = plan_pulses(model, pose, low_deg, high_deg, seed, duration_s, **case.changes)
    record = shake(model, plan, seed)
    real = truth(model, record)
    return Run(
        pose=pose,
        span_deg=high_deg - low_deg,
        case=case,
        record=record,
        truth=real,
        result=identify(record),
        at_start_hz=model.modes(model.pose(pose)).frequency_hz[: len(real.frequency_hz)],
    )


def tabulate(found: Run, keep: str = '') -> None:
    rows = []
    for index, mean_hz in enumerate(found.truth.mean_hz):
        path_hz = found.truth.over_path_hz[:, index]
        at_start = found.at_start_hz[index]
        listed = ['', '*'][any(abs(at_start / f - 1.0) < 0.01 for f in PUBLISHED_HZ[found.pose])]
        mode = found.pairs.get(index)
        cells = ('-',) * 5
        if mode is not None:
            off = mode.frequency_hz - mean_hz
            cells = (
                f'{mode.frequency_hz:.2f} ± {mode.frequency_std_hz:.2f}',
                f'{100 * off / mean_hz:+.2f}',
                f'{abs(off) / mode.frequency_std_hz:.1f}',
                f'{100 * (mode.frequency_hz / at_start - 1.0):+.2f}',
                f'{100 * mode.damping_ratio:.2f} ± {100 * mode.damping_ratio_std:.2f}',
            )
        rows.append(
            (
                f'{at_start:.2f}{listed}',
                f'{mean_hz:.2f} ({path_hz.min():.2f} to {path_hz.max():.2f})',
                *cells,
                f'{100 * found.truth.damping_ratio[index]:.2f}',
            )
        )
    span = f'+{found.span_deg:g}°' if found.span_deg else 'at the centre'
    show_table(
        f'Table 8 in kind, {found.pose} {span}, {found.case.name}:'
        f' {len(found.pairs)} of {len(rows)} modes, {len(found.extra)} not real',
        (
            'at start [Hz]',
            'over the path [Hz]',
            'identified',
            'off [%]',
            'in σ',
            'from start [%]',
            'damping [%]',
            'true',
        ),
        rows,
        keep=keep,
    )
    for mode in found.extra:
        say(
            f'not real: {mode.frequency_hz:.2f} ± {mode.frequency_std_hz:.2f} Hz,'
            f' damping {100 * mode.damping_ratio:.1f} %'
        )


def tabulate_ways(runs: list[Run], keep: str) -> None:
    """Print what each way of shaking finds of each region."""
    rows = []
    for case in dict.fromkeys(found.case.name for found in runs):
        cells = []
        for found in (each for each in runs if each.case.name == case):
            true_hz = found.truth.mean_hz
            off = [abs(mode.frequency_hz / true_hz[i] - 1.0) for i, mode in found.pairs.items()]
            cells += [
                f'{len(found.pairs)} of {len(true_hz)}',
                len(found.extra),
                f'{100 * max(off, default=float("nan")):.2f}',
            ]
        rows.append((case, *cells))
    columns = [
        f'{pose}: {what}' for pose, *_ in REGIONS for what in ('modes', 'not real', 'largest [%]')
    ]
    show_table('Ways of shaking', ('way', *columns), rows, keep=keep)


def published(found: Run) -> list[int]:
    """Return the true modes that the paper lists, by their frequency at the start."""
    return [
        index
        for index, hz in enumerate(found.at_start_hz)
        if any(abs(hz / listed - 1.0) < 0.01 for listed in PUBLISHED_HZ[found.pose])
    ]


def findings(runs: list[Run]) -> list[Finding]:
    """Return what became of Table 8: the paper's way of shaking."""
    listed = [(found, index) for found in runs for index in published(found)]
    n_found = sum(index in found.pairs for found, index in listed)
    n_all, n_true = (sum(map(len, parts)) for parts in (
        [found.pairs for found in runs], [found.truth.mean_hz for found in runs]
    ))  # fmt: skip
    moved_hz = [
        abs(mode.frequency_hz - found.at_start_hz[index])
        for found in runs
        for index, mode in found.pairs.items()
    ]
    return [
        Finding(
            'Table 8: self-excitation identifies the first four modes of P1 and P3',
            f'{n_found} of the {len(listed)} modes the paper lists, {n_all} of all {n_true}',
            REPRODUCED if n_found == len(listed) else PARTLY,
        ),
        Finding(
            f'Sect. 5.1: differences to the first posture (to {LARGEST_SHIFT_HZ:g} Hz) are of the'
            ' joints, not of the pose',
            f'with no difference in the joints the pose alone makes up to {max(moved_hz):.1f} Hz',
            PARTLY if max(moved_hz) > 0.1 * LARGEST_SHIFT_HZ else REPRODUCED,
        ),
    ]


def draw(runs: list[Run]) -> None:
    figure, axes = panels(1, len(runs), (11.0, 3.8))
    for axis, found in zip(axes[0], runs, strict=True):
        spectrum = found.result.spectrum
        for column, colour in zip(spectrum.singular_value.T[:2], (COLOURS[0], GREY), strict=True):
            axis.semilogy(spectrum.frequency_hz, column, color=colour, lw=0.9)
        for path in found.truth.over_path_hz.T:
            axis.axvspan(path.min(), path.max(), color=COLOURS[3], alpha=0.25, lw=0)
        for mode in found.result.modes:
            axis.axvline(mode.frequency_hz, color=COLOURS[1], lw=1.0)
        inside = spectrum.frequency_hz > 5.0
        axis.set_ylim(0.3 * spectrum.singular_value[inside, 1].min(), None)
        axis.set(xlim=(5, 60), xlabel='frequency [Hz]', ylabel='singular values [(m/s²)²/Hz]')
        axis.set_title(f'{found.pose}, {found.case.name}')
    axes[0][-1].plot([], [], color=COLOURS[1], label='identified')
    axes[0][-1].fill_between([], [], color=COLOURS[3], alpha=0.25, label='true, over the path')
    axes[0][-1].legend()
    save(
        figure,
        'self_excitation_drawn',
        'Fig. 11 in kind: spectra at P1 and P3, identified and true frequencies',
    )


def main(seed: int = SEED) -> None:
    say(f'Records of {DURATION_S:g} s, seed {seed} for motion and sensor noise.')
    runs = []
    for pose, low_deg, high_deg in REGIONS:
        for case in (AS_PAPER, SLOW):
            runs.append(run(pose, low_deg, high_deg, case, seed))
            kept = pose.lower() if case is AS_PAPER and seed == SEED else ''
            tabulate(runs[-1], kept)
        say(f'published: {PUBLISHED_HZ[pose]} Hz; * marks the model modes fitted to them\n')
        middle = 0.5 * (low_deg + high_deg)
        runs.append(run(pose, middle, middle, NOISE, seed))
        tabulate(runs[-1])
    tabulate_ways(runs, 'ways' if seed == SEED else '')
    as_paper = [found for found in runs if found.case is AS_PAPER]
    show_findings(SECTION, findings(as_paper), keep=seed == SEED)
    if seed == SEED:
        draw(as_paper)


if __name__ == '__main__':
    typer.run(main)
