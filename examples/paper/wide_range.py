"""Range too wide: what the identified modes do when the sensitivity limit is ignored.

Run ``python -m examples.paper.wide_range``.
"""

from dataclasses import dataclass

import numpy as np
import typer

from examples.paper.cell import robot
from examples.paper.drawing import COLOURS, GREY, panels, save
from examples.paper.output import (
    Finding,
    NOT_REPRODUCED,
    PARTLY,
    REPRODUCED,
    say,
    show_findings,
    show_table,
)
from examples.paper.self_excitation import AS_PAPER, DURATION_S, Run, run, SEED
from examples.paper.sensitivity import allowed_deg

# Centre of the motion as an offset from the pose, and the half ranges tried around it [deg].  At
# P1 the rod allows no more than these 7.5 deg.
REGIONS = {'P1': (7.5, (1.0, 2.5, 5.0, 7.5)), 'P3': (0.0, (1.0, 2.5, 5.0, 10.0))}
TOLERANCE = 0.02
SECTION = '7 Range'


@dataclass(frozen=True)
class Summary:
    """One run in a few numbers; errors over the modes that were found."""

    found: Run
    half_range_deg: float

    @property
    def smear(self) -> float:
        """Largest spread of a true frequency over the path, relative."""
        path = self.found.truth.over_path_hz
        return float(np.max(np.ptp(path, axis=0) / self.found.truth.mean_hz))

    @property
    def frequency_error(self) -> np.ndarray:
        """Identified over the mean of the true ones over the path, less 1."""
        mean_hz = self.found.truth.mean_hz
        return np.array([m.frequency_hz / mean_hz[i] - 1.0 for i, m in self.found.pairs.items()])

    @property
    def surprise(self) -> np.ndarray:
        """The same in the identifier's own standard deviations."""
        mean_hz = self.found.truth.mean_hz
        return np.array(
            [
                (m.frequency_hz - mean_hz[i]) / m.frequency_std_hz
                for i, m in self.found.pairs.items()
            ]
        )

    @property
    def damping_factor(self) -> np.ndarray:
        """Identified over true damping."""
        true = self.found.truth.damping_ratio
        return np.array([m.damping_ratio / true[i] for i, m in self.found.pairs.items()])


def summaries(pose: str, duration_s: float = DURATION_S, seed: int = SEED) -> list[Summary]:
    """Shake one region with growing range."""
    offset_deg, half_ranges = REGIONS[pose]
    return [
        Summary(run(pose, offset_deg - half, offset_deg + half, AS_PAPER, seed, duration_s), half)
        for half in half_ranges
    ]


def tabulate(pose: str, sweep: list[Summary], seed: int) -> None:
    rows = []
    for each in sweep:
        n_modes = len(each.found.truth.frequency_hz)
        rows.append(
            (
                f'±{each.half_range_deg:g}°',
                f'{100 * each.smear:.1f}',
                f'{len(each.found.pairs)} of {n_modes}',
                len(each.found.extra),
                f'{100 * np.median(np.abs(each.frequency_error)):.2f}',
                f'{100 * np.max(np.abs(each.frequency_error)):.2f}',
                f'{np.max(np.abs(each.surprise)):.1f}',
                f'{np.median(each.damping_factor):.2f}',
                f'{np.max(each.damping_factor):.2f}',
            )
        )
    centre = f' +{REGIONS[pose][0]:g}°' if REGIONS[pose][0] else ''
    show_table(
        f'Range too wide, around {pose}{centre}, {DURATION_S:g} s, seed {seed}',
        (
            'range',
            'true spread [%]',
            'modes',
            'not real',
            '|error| [%]',
            'largest',
            'in σ',
            'damping / true',
            'largest',
        ),
        rows,
        keep=f'wide_{pose.lower()}' if seed == SEED else '',
    )


def findings(sweeps: dict[str, list[Summary]]) -> list[Finding]:
    """Return whether a range beyond what the sensitivity allows costs modes and accuracy."""
    inside, beyond = ([sweep[end] for sweep in sweeps.values()] for end in (0, -1))
    lost = [
        sum(len(each.found.truth.frequency_hz) - len(each.found.pairs) for each in part)
        for part in (inside, beyond)
    ]
    damping = [np.median(np.concatenate([e.damping_factor for e in p])) for p in (inside, beyond)]
    worse = [lost[1] > lost[0], damping[1] > 1.1 * damping[0]]
    narrow, wide = (
        ' and '.join(f'±{each.half_range_deg:g}°' for each in part) for part in (inside, beyond)
    )
    return [
        Finding(
            'Sect. 3: the range of the joints must respect the sensitivity',
            f'{lost[0]} modes lost and damping {damping[0]:.2f} times the true one at {narrow};'
            f' {lost[1]} and {damping[1]:.2f} at {wide}',
            REPRODUCED if all(worse) else PARTLY if any(worse) else NOT_REPRODUCED,
        )
    ]


def draw(sweeps: dict[str, list[Summary]], limits_deg: dict[str, float]) -> None:
    figure, axes = panels(2, len(sweeps), (11.0, 6.6))
    for column, (pose, sweep) in enumerate(sweeps.items()):
        top, bottom = axes[0][column], axes[1][column]
        ranges = np.array([each.half_range_deg for each in sweep])
        paths = np.array([each.found.truth.over_path_hz for each in sweep], dtype=object)
        for index in range(paths[0].shape[1]):
            colour = COLOURS[index % len(COLOURS)]
            low = [path[:, index].min() for path in paths]
            high = [path[:, index].max() for path in paths]
            top.fill_between(ranges, low, high, color=colour, alpha=0.25, lw=0)
            for each in sweep:
                mode = each.found.pairs.get(index)
                if mode is None:
                    continue
                top.errorbar(
                    each.half_range_deg,
                    mode.frequency_hz,
                    2.0 * mode.frequency_std_hz,
                    fmt='o',
                    color=colour,
                    ms=4,
                )
                bottom.errorbar(
                    each.half_range_deg * (1.0 + 0.02 * (index - 3)),
                    mode.damping_ratio / each.found.truth.damping_ratio[index],
                    2.0 * mode.damping_ratio_std / each.found.truth.damping_ratio[index],
                    fmt='o',
                    color=colour,
                    ms=4,
                )
        for each in sweep:
            for mode in each.found.extra:
                top.plot(each.half_range_deg, mode.frequency_hz, 'kx', ms=5)
        for axis in (top, bottom):
            axis.axvline(limits_deg[pose], color=GREY, ls=':')
        bottom.axhline(1.0, color=GREY, lw=0.8)
        top.set_title(f'{pose}: band true over the path, dots identified ± 2σ, x not real')
        bottom.set_title(f'dotted: range for {100 * TOLERANCE:g} % of frequency')
        bottom.set(xlabel='half range of all axes [deg]', ylim=(0, 3.5))
    axes[0][0].set_ylabel('natural frequency [Hz]')
    axes[1][0].set_ylabel('damping, identified / true')
    save(
        figure,
        'wide_range_drawn',
        'Identified frequencies and damping over the range of motion, P1 and P3',
    )


def main(seed: int = SEED) -> None:
    model = robot()
    sweeps, limits_deg = {}, {}
    for pose in REGIONS:
        sweeps[pose] = summaries(pose, seed=seed)
        tabulate(pose, sweeps[pose], seed)
        centre = sweeps[pose][0].found.record.plan.start_position
        limits_deg[pose] = allowed_deg(model, centre, TOLERANCE)
        say(f'{pose}: a change of {100 * TOLERANCE:g} % allows ±{limits_deg[pose]:.2f}°')
    show_findings(SECTION, findings(sweeps), keep=seed == SEED)
    if seed == SEED:
        draw(sweeps, limits_deg)


if __name__ == '__main__':
    typer.run(main)
