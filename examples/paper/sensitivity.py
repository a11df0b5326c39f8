"""Figs. 3-7, Tables 1-5: which region is sensitive to the pose, predicted and actual.

Run ``python -m examples.paper.sensitivity``.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import spearmanr

from examples.paper.cell import HIGHEST_HZ, ROBOT, robot
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
from excitation_planner.pose_range.allowed_range import allowed_range
from excitation_planner.pose_range.mode_following import follow, modes_at
from excitation_planner.pose_range.sensitivity import (
    actual_change,
    added_mass_change,
    predicted_change,
)
from structural_model import load_layout
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]
SEED = 2025
SECTION = '3 Sensitivity'
REGIONS = ('P1', 'P2', 'P3')
STEPS_DEG = (5.0, 10.0, 15.0)
SMALL_DEG = 1.0
TOLERANCES = (0.02, 0.05)
# Modes the published frequencies were assigned to in the fit, counted from 0 (model.yaml, fit).
PUBLISHED = {'P1': (1, 2, 4, 5), 'P3': (0, 3, 4, 6)}
ADDED_MASS_KG = 10.0


@dataclass(frozen=True)
class Region:
    """One region: its modes, and what turning all axes together does to them.

    ``actual`` and ``predicted`` are (n_steps, n_modes), signed relative changes, modes followed by
    shape; ``by_size`` is Eq. (11) for a small mass at the sensors, the mean over sensors.
    """

    pose: str
    frequency_hz: Array
    damping_ratio: Array
    steps_deg: tuple[float, ...]
    actual: Array
    predicted: Array
    by_size: Array
    published: tuple[int, ...]

    @property
    def order_kept(self) -> bool:
        """No mode overtakes another on the way."""
        return bool(np.all(np.diff(self.frequency_hz * (1.0 + self.actual), axis=1) > 0.0))

    def at(self, step_deg: float) -> int:
        """Return the row of a step."""
        return self.steps_deg.index(step_deg)


def region(model: FlexibleJointModel, pose: str) -> Region:
    """Compute everything about one region; every posture must lie inside the joint ranges."""
    q = model.check_pose(model.pose(pose))
    modes = model.modes(q, load_layout(ROBOT).channels)
    n_modes = int(np.sum(modes.frequency_hz <= HIGHEST_HZ))
    steps = (SMALL_DEG, *STEPS_DEG)
    axis = model.to_controller(q)
    others = [model.check_pose(model.to_serial(axis + np.deg2rad(step))) for step in steps]
    functions = [make(model, q, HIGHEST_HZ) for make in (actual_change, predicted_change)]
    actual, predicted = (np.array([change(other) for other in others]) for change in functions)
    added = added_mass_change(modes.channel_shapes[:, :n_modes], ADDED_MASS_KG)
    return Region(
        pose=pose,
        frequency_hz=modes.frequency_hz[:n_modes],
        damping_ratio=modes.damping_ratio[:n_modes],
        steps_deg=steps,
        actual=actual,
        predicted=predicted,
        by_size=np.mean(np.abs(added), axis=0),
        published=_published(model, pose, q),
    )


def most_sensitive(values: list[Array]) -> list[str]:
    """Return the region with the largest value of each mode; values as (n_modes,) per region."""
    return [REGIONS[index] for index in np.argmax(np.abs(values), axis=0)]


def allowed_deg(
    model: FlexibleJointModel, q: Array, tolerance: float, n_modes: int | None = None
) -> float:
    """Return how far all axes may turn either way before one of the first modes changes more."""
    change = actual_change(model, q, HIGHEST_HZ)
    found = allowed_range(
        lambda other: change(other)[:n_modes],
        q,
        np.ones(len(q)),
        tolerance,
        model.limits,
        np.random.default_rng(SEED),
    )
    return float(np.rad2deg(found.half_range.min()))


def tabulate(regions: list[Region], *, published: bool) -> None:
    """Print actual and predicted changes of four modes of every region."""
    rows = []
    for each in regions:
        picks = list(each.published if published else range(4))
        frequencies = ' '.join(f'{f:6.2f}' for f in each.frequency_hz[picks])
        for step in STEPS_DEG:
            cells = [
                ' '.join(f'{100 * value:+6.2f}' for value in values[each.at(step)][picks])
                for values in (each.actual, each.predicted)
            ]
            rows.append((each.pose, frequencies, f'+{step:g}°', *cells))
    which = 'modes the paper listed' if published else 'first four modes'
    show_table(
        f'Tables 1-5 in kind, {which}: change of natural frequency [%]',
        ('region', 'frequencies [Hz]', 'all axes', 'actual, Eq. (1)', 'predicted, Eqs. (5)-(11)'),
        rows,
        keep='' if published else 'sensitivity',
    )


def tabulate_regions(regions: list[Region], *, published: bool) -> None:
    """Print which region is the most sensitive in each mode."""
    picks = [list(each.published if published else range(4)) for each in regions]
    rows = []
    sizes = [each.by_size[pick] for each, pick in zip(regions, picks, strict=True)]
    for step in STEPS_DEG:
        actual, predicted = (
            [values(each)[each.at(step)][pick] for each, pick in zip(regions, picks, strict=True)]
            for values in (lambda each: each.actual, lambda each: each.predicted)
        )
        named = [most_sensitive(values) for values in (actual, predicted, sizes)]
        agree = [sum(a == b for a, b in zip(named[0], other, strict=True)) for other in named[1:]]
        ranks = [
            spearmanr(np.abs(np.ravel(actual)), np.abs(np.ravel(other))).statistic
            for other in (predicted, sizes)
        ]
        rows.append(
            (
                f'+{step:g}°',
                *(' '.join(names) for names in named),
                f'{agree[0]} and {agree[1]} of 4',
                f'{ranks[0]:+.2f} and {ranks[1]:+.2f}',
            )
        )
    which = 'modes the paper listed' if published else 'first four modes'
    show_table(
        f'Fig. 7 in kind, {which}: the most sensitive region of each',
        ('all axes', 'actual', 'predicted, ΔM', 'largest shape', 'agree', 'rank correlation'),
        rows,
    )


def tabulate_accuracy(regions: list[Region]) -> None:
    """Print how well the shape-based prediction does as the step grows."""
    rows = []
    for step in (SMALL_DEG, *STEPS_DEG):
        for low, high in ((0.0, 25.0), (25.0, HIGHEST_HZ)):
            actual, predicted = (
                np.concatenate(
                    [values(each)[each.at(step)][_inside(each, low, high)] for each in regions]
                )
                for values in (lambda each: each.actual, lambda each: each.predicted)
            )
            error = predicted - actual
            rows.append(
                (
                    f'+{step:g}°',
                    f'{low:g} to {high:g} Hz',
                    len(actual),
                    f'{100 * np.median(np.abs(actual)):.2f}',
                    f'{100 * np.median(np.abs(error)):.2f}',
                    f'{100 * np.max(np.abs(error)):.2f}',
                    f'{np.sum(np.sign(actual) == np.sign(predicted))}',
                )
            )
    show_table(
        'Shape-based prediction against Eq. (1), all modes below 60 Hz of the three regions [%]',
        ('all axes', 'band', 'modes', 'median change', 'median error', 'largest', 'sign right'),
        rows,
        keep='accuracy',
    )


def ranges_deg(model: FlexibleJointModel, regions: list[Region]) -> dict[str, list[float]]:
    """Return how far the axes may turn in each region: tolerances by four modes or all."""
    return {
        each.pose: [
            allowed_deg(model, model.pose(each.pose), tolerance, n_modes)
            for tolerance in TOLERANCES
            for n_modes in (4, None)
        ]
        for each in regions
    }


def tabulate_ranges(allowed: dict[str, list[float]]) -> None:
    """Print how far the axes may turn in each region."""
    rows = [(pose, *(f'±{deg:.2f}°' for deg in ranges)) for pose, ranges in allowed.items()]
    columns = [
        f'{100 * tolerance:g} %, {which}'
        for tolerance in TOLERANCES
        for which in ('first 4', 'all to 60 Hz')
    ]
    show_table(
        f'How far all axes may turn, any combination of signs, seed {SEED}',
        ('region', *columns),
        rows,
        keep='ranges',
    )


def findings(regions: list[Region], allowed: dict[str, list[float]]) -> list[Finding]:
    """Return what became of Figs. 3-7."""
    actual, predicted, by_size = (
        [values(each)[:4] for each in regions]
        for values in (
            lambda each: each.actual[each.at(5.0)],
            lambda each: each.predicted[each.at(5.0)],
            lambda each: each.by_size,
        )
    )
    ranks = [
        spearmanr(np.abs(np.ravel(actual)), np.abs(np.ravel(other))).statistic
        for other in (predicted, by_size)
    ]
    named = most_sensitive(actual)
    agree = [
        sum(a == b for a, b in zip(named, most_sensitive(other), strict=True))
        for other in (predicted, by_size)
    ]
    first = {pose: ranges[0] for pose, ranges in allowed.items()}
    says = [
        f'{agree_} of 4 regions named, rank correlation {rank:+.1f}'
        for agree_, rank in zip(agree, ranks, strict=True)
    ]
    order = sorted(first, key=first.__getitem__, reverse=True)
    return [
        Finding(
            'Sect. 2.1: mode shapes predict the change of frequency',
            f'with the change of the mass matrix as the added mass, at +5°: {says[0]}',
            _verdict(ranks[0]),
        ),
        Finding(
            'Figs. 3, 7: the region of the largest shape is the most sensitive',
            f'the size of the shapes at the sensors: {says[1]}',
            _verdict(ranks[1]),
        ),
        Finding(
            'Sect. 3: P1 is less restricted than P2 and P3',
            f'{100 * TOLERANCES[0]:g} % of frequency allow '
            + ', '.join(f'±{first[pose]:.1f}° at {pose}' for pose in order),
            REPRODUCED if order[0] == 'P1' else NOT_REPRODUCED,
        ),
    ]


def _verdict(rank: float) -> str:
    """Return what a rank correlation comes to: 0.8 and 0.4 (assumed)."""
    return REPRODUCED if rank >= 0.8 else PARTLY if rank >= 0.4 else NOT_REPRODUCED


def draw(regions: list[Region]) -> None:
    figure, axes = panels(2, 4, (11.0, 5.6))
    for mode in range(4):
        for row, published in enumerate((False, True)):
            axis = axes[row][mode]
            for each, colour in zip(regions, COLOURS, strict=False):
                pick = each.published[mode] if published else mode
                for values, style in ((each.actual, 'o-'), (each.predicted, 'x:')):
                    axis.plot(
                        each.steps_deg,
                        100 * np.abs(values[:, pick]),
                        style,
                        color=colour,
                        ms=4,
                        lw=1.2,
                        label=each.pose if style == 'o-' else None,
                    )
            axis.set_title(f'{"published" if published else "model"} mode {mode + 1}')
            axis.set(xticks=STEPS_DEG, ylim=(0, None))
        axes[1][mode].set_xlabel('all axes turned by [deg]')
    for row in range(2):
        axes[row][0].set_ylabel('|change| of frequency [%]')
    handles, labels = axes[0][0].get_legend_handles_labels()
    for style, text in (('o-', 'actual, Eq. (1)'), ('x:', 'predicted from shapes')):
        handles.append(axes[0][0].plot([], [], style, color=GREY, ms=4)[0])
        labels.append(text)
    figure.legend(handles, labels, loc='outside lower center', ncols=5)
    save(
        figure,
        'sensitivity_drawn',
        'Fig. 7 in kind: actual and predicted change of frequency in three regions',
    )


def _inside(each: Region, low_hz: float, high_hz: float) -> NDArray[np.bool_]:
    return np.asarray((each.frequency_hz >= low_hz) & (each.frequency_hz < high_hz))


def _published(model: FlexibleJointModel, pose: str, q: Array) -> tuple[int, ...]:
    """Return the published modes of a region; those of P2, which has none, followed from P3."""
    if pose in PUBLISHED:
        return PUBLISHED[pose]
    origin = model.pose('P3')
    reached = follow(model, modes_at(model, origin, HIGHEST_HZ), origin, q)
    here = model.modes(q).frequency_hz
    return tuple(
        int(np.argmin(np.abs(here - reached.frequency_hz[mode]))) for mode in PUBLISHED['P3']
    )


def main() -> None:
    model = robot()
    regions = [region(model, pose) for pose in REGIONS]
    for published in (False, True):
        tabulate(regions, published=published)
        tabulate_regions(regions, published=published)
    tabulate_accuracy(regions)
    allowed = ranges_deg(model, regions)
    tabulate_ranges(allowed)
    kept = ', '.join(each.pose for each in regions if each.order_kept)
    say(f'The order of the modes below 60 Hz stays the same at all steps in: {kept}.')
    say(
        'Turning all axes by -15° from P1 would leave the range of axis 3 (-25°, limit -20°); '
        'the twelve postures of the paper are inside all ranges.'
    )
    show_findings(SECTION, findings(regions, allowed), keep=True)
    draw(regions)


if __name__ == '__main__':
    main()
