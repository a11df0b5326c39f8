"""Figs. 12-14: all joints against joint 6 alone, zero pose, 5 degrees.

Run ``python -m examples.paper.all_joints``.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
import typer

from examples.paper.cell import (
    HIGHEST_HZ,
    identify,
    LOWEST_HZ,
    matched,
    NOISE_DENSITY,
    plan_pulses,
    Record,
    ROBOT,
    robot,
    SAMPLE_RATE_HZ,
    settings,
    shake,
    Truth,
    truth,
)
from examples.paper.drawing import COLOURS, GREY, PALE, panels, save
from examples.paper.output import (
    Finding,
    NOT_REPRODUCED,
    PARTLY,
    REPRODUCED,
    say,
    show_findings,
    show_table,
)
from modal_core.mode import Mode, ModeSet
from modal_core.numbers.indicators import mac
from modal_core.poles import PoleStatus, PoleTable
from modal_core.samples import Samples
from oma_identifier.methods import identify_by
from oma_identifier.spectra import SingularValueSpectrum
from structural_model import load_layout

SEED = 2025
DURATION_S = 120.0
SECTION = '6 All joints or one'
ORDERS = (40, 60)
# The emulated sensors' own noise, and that of a hall with machines running.
HALL_DENSITY = 30.0 * NOISE_DENSITY
NOISE = {'quiet': NOISE_DENSITY, 'hall': HALL_DENSITY}
JOINTS: dict[str, list[str]] = {'all joints': [], 'joint 6': ['joint_6']}
# A pole that its neighbour order confirms, whether or not it became a mode.
STABLE = (
    PoleStatus.KEPT,
    PoleStatus.HARMONIC,
    PoleStatus.CLUSTER_OUTLIER,
    PoleStatus.SMALL_CLUSTER,
    PoleStatus.UNCERTAIN,
    PoleStatus.COMPLEX_SHAPE,
    PoleStatus.WEAK,
)
TRUE_FREQUENCY, TRUE_MAC = 0.03, 0.8
NO_DRIVE_DB = 100.0
# From here on a response is "far larger": ten times in amplitude (assumed).
LARGER_DB = 20.0


@dataclass(frozen=True)
class PoleCount:
    """Poles of all orders up to one, between 5 and 60 Hz, without those of negative damping."""

    method: str
    max_order: int
    poles: PoleTable
    modes: ModeSet
    truth: Truth

    @property
    def stable(self) -> NDArray[np.bool_]:
        """Poles that a neighbouring order confirms."""
        return np.isin(self.poles.status, [int(status) for status in STABLE])

    @property
    def real(self) -> NDArray[np.bool_]:
        """Poles that are near a true mode in frequency and shape."""
        ratio = self.poles.frequency_hz[:, None] / self.truth.mean_hz
        near = np.abs(ratio - 1.0) < TRUE_FREQUENCY
        alike = mac(self.poles.shape, self.truth.channel_shapes) > TRUE_MAC
        return np.asarray(np.any(near & alike, axis=1))


@dataclass(frozen=True)
class Experiment:
    """One way to move in one surrounding."""

    joints: str
    noise: str
    record: Record
    truth: Truth
    spectrum: SingularValueSpectrum
    counts: tuple[PoleCount, ...]

    @property
    def rms(self) -> float:
        """Of all channels together, without rest values [m/s²]."""
        return float(np.sqrt(np.mean(np.var(self.record.acceleration, axis=0))))

    @property
    def peak_density(self) -> float:
        """Largest singular value between 5 and 60 Hz [(m/s²)²/Hz]."""
        inside = self.spectrum.frequency_hz > LOWEST_HZ
        return float(np.max(self.spectrum.singular_value[inside, 0]))

    @property
    def covariance_driven(self) -> tuple[PoleCount, ...]:
        """What the pipeline's own method finds, per highest order."""
        return tuple(count for count in self.counts if count.method == 'ssi_cov')

    @property
    def pairs(self) -> dict[int, Mode]:
        """Identified mode of each true one, highest order."""
        return matched(self.covariance_driven[-1].modes.modes, self.truth)


def experiments(
    duration_s: float = DURATION_S, orders: tuple[int, ...] = ORDERS, seed: int = SEED
) -> list[Experiment]:
    """Shake with all joints and with joint 6, in a quiet cell and in a hall."""
    model = robot()
    found = []
    for joints, names in JOINTS.items():
        plan = plan_pulses(model, 'P2', 0.0, 5.0, seed, duration_s, joints=names)
        for noise, density in NOISE.items():
            record = shake(model, plan, seed, density)
            found.append(_evaluated(joints, noise, record, truth(model, record), orders))
    return found


def _evaluated(
    joints: str, noise: str, record: Record, real: Truth, orders: tuple[int, ...]
) -> Experiment:
    samples = Samples(record.acceleration, SAMPLE_RATE_HZ, load_layout(ROBOT).channels)
    counts = []
    for order in orders:
        result = identify(record, order)
        counts.append(_count('ssi_cov', order, result.poles, result.modes, real))
        other = identify_by('plscf', samples, settings(record, order))
        counts.append(_count('plscf', order, other.poles, other.modes, real))
    return Experiment(joints, noise, record, real, result.spectrum, tuple(counts))


def _count(
    method: str, max_order: int, poles: PoleTable, modes: ModeSet, real: Truth
) -> PoleCount:
    frequency_hz = poles.frequency_hz
    shown = (
        (poles.damping_ratio > 0.0) & (frequency_hz >= LOWEST_HZ) & (frequency_hz <= HIGHEST_HZ)
    )
    table = PoleTable(
        poles.model_order[shown],
        poles.pole[shown],
        poles.shape[:, shown],
        poles.status[shown],
        poles.mode_id[shown],
    )
    return PoleCount(method, max_order, table, modes, real)


def tabulate(found: list[Experiment], seed: int) -> None:
    strongest = found[0].peak_density
    show_table(
        f'Fig. 12 in kind: zero pose, 0 to 5°, {DURATION_S:g} s, seed {seed}',
        (
            'moved, noise',
            'rank D(τ)',
            'rms [m/s²]',
            'peak density [(m/s²)²/Hz]',
            '[dB]',
            'modes found',
        ),
        [
            (
                f'{each.joints}, {each.noise}',
                each.record.plan.torque_projection_rank,
                f'{each.rms:.3f}',
                f'{each.peak_density:.3g}',
                f'{10 * np.log10(each.peak_density / strongest):.1f}',
                f'{len(each.pairs)} of {len(each.truth.frequency_hz)}',
            )
            for each in found
        ],
        keep='all_joints' if seed == SEED else '',
    )
    rows = []
    for each in found:
        for count in each.counts:
            n_poles, n_stable = len(count.stable), int(np.sum(count.stable))
            rows.append(
                (
                    f'{each.joints}, {each.noise}',
                    count.method,
                    count.max_order,
                    n_poles,
                    n_stable,
                    n_poles - n_stable,
                    f'{100 * (n_poles - n_stable) / max(n_poles, 1):.0f} %',
                    int(np.sum(count.stable & count.real)),
                    int(np.sum(~count.real)),
                    len(count.modes),
                )
            )
    show_table(
        'Figs. 13 and 14 in kind: poles from 5 to 60 Hz at orders up to 40 and up to 60',
        (
            'moved, noise',
            'method',
            'order',
            'poles',
            'stable',
            'unstable',
            'share',
            'stable, real',
            'not real',
            'modes',
        ),
        rows,
        keep='poles' if seed == SEED else '',
    )


def predicted_loss(found: list[Experiment], index: int) -> str:
    """Return how much weaker joint 6 alone shows a mode, as the planner foresees it."""
    plans = [next(e.record.plan for e in found if e.joints == joints) for joints in JOINTS]
    ratios_db = [
        plan.prediction.modes[index].signal_to_noise_db
        for plan in plans
        if plan.prediction is not None
    ]
    loss_db = ratios_db[0] - ratios_db[1]
    return f'{loss_db:.0f}' if loss_db < NO_DRIVE_DB else 'not driven'


def tabulate_modes(found: list[Experiment]) -> None:
    """Print which modes each way of moving shows."""
    rows = []
    for index, frequency_hz in enumerate(found[0].truth.mean_hz):
        cells = [predicted_loss(found, index)]
        for each in found:
            mode = each.pairs.get(index)
            cells.append(
                '-' if mode is None else f'{mode.frequency_hz:.2f} ± {mode.frequency_std_hz:.2f}'
            )
        rows.append((f'{frequency_hz:.2f}', *cells))
    show_table(
        'Modes identified at order 60 [Hz]',
        ('true, mean', 'predicted loss [dB]', *(f'{each.joints}, {each.noise}' for each in found)),
        rows,
    )


def findings(found: list[Experiment]) -> list[Finding]:
    """Return what became of Figs. 12-14."""
    by_name = {(each.joints, each.noise): each for each in found}
    every, one = (by_name[joints, 'quiet'] for joints in JOINTS)
    loss_db = 10.0 * np.log10(every.peak_density / one.peak_density)
    unstable = {
        joints: {
            method: sum(
                int(np.sum(~count.stable))
                for each in found
                for count in each.counts
                if each.joints == joints and count.method == method
            )
            for method in ('ssi_cov', 'plscf')
        }
        for joints in JOINTS
    }
    more = [unstable['joint 6'][m] > unstable['all joints'][m] for m in unstable['joint 6']]
    modes = {key: len(each.pairs) for key, each in by_name.items()}
    fewer = all(modes['joint 6', noise] < modes['all joints', noise] for noise in NOISE)
    ranks = [each.record.plan.torque_projection_rank for each in (every, one)]
    return [
        Finding(
            'Fig. 12: all joints give a far larger response than joint 6',
            f'by {loss_db:.0f} dB at the strongest peak',
            REPRODUCED if loss_db > LARGER_DB else NOT_REPRODUCED,
        ),
        Finding(
            'Sect. 4.1: torques of all joints span all directions',
            f'rank {ranks[0]} of D(τ) at equal accelerations of all joints, {ranks[1]} by joint 6',
            REPRODUCED if ranks[0] == 3 else NOT_REPRODUCED,
        ),
        Finding(
            'Figs. 13, 14: joint 6 alone gives more unstable poles',
            '; '.join(
                f'{m}: {unstable["joint 6"][m]} against {unstable["all joints"][m]}'
                for m in unstable['joint 6']
            ),
            REPRODUCED if all(more) else PARTLY if any(more) else NOT_REPRODUCED,
        ),
        Finding(
            'Sect. 5.2: all joints identify the arm more effectively',
            ', '.join(
                f'{noise}: {modes["all joints", noise]} modes against {modes["joint 6", noise]}'
                for noise in NOISE
            ),
            REPRODUCED if fewer else PARTLY,
        ),
    ]


def draw(found: list[Experiment]) -> None:
    figure, axes = panels(2, 4, (12.0, 6.4))
    for column, each in enumerate(found):
        top, bottom = axes[0][column], axes[1][column]
        spectrum = each.spectrum
        for axis, count in zip((top, bottom), each.covariance_driven, strict=True):
            poles = count.poles
            behind = axis.twinx()
            behind.semilogy(
                spectrum.frequency_hz, spectrum.singular_value[:, 0], color=PALE, lw=0.8
            )
            behind.set_ylim(1e-7, 1e2)
            behind.grid(visible=False)
            behind.set_yticks([])
            behind.minorticks_off()
            axis.set_zorder(behind.get_zorder() + 1)
            axis.patch.set_visible(False)
            for chosen, colour, marker in (
                (~count.stable, COLOURS[1], 'x'),
                (count.stable, COLOURS[0], 'o'),
            ):
                axis.scatter(
                    poles.frequency_hz[chosen],
                    poles.model_order[chosen],
                    s=6 if marker == 'o' else 8,
                    marker=marker,
                    color=colour,
                    linewidths=0.6,
                )
            for frequency_hz in count.truth.mean_hz:
                axis.axvline(frequency_hz, color=GREY, lw=0.6, ls=':')
            axis.set(xlim=(5, 60), ylim=(0, count.max_order + 2))
            axis.set_title(f'{each.joints}, {each.noise}: {np.sum(~count.stable)} unstable')
        bottom.set_xlabel('frequency [Hz]')
    for row in range(2):
        axes[row][0].set_ylabel('model order')
    axes[0][0].scatter([], [], s=10, marker='o', color=COLOURS[0], label='stable pole')
    axes[0][0].scatter([], [], s=10, marker='x', color=COLOURS[1], label='unstable pole')
    axes[0][0].plot([], [], color=PALE, label='largest singular value (1e-7 to 1e2)')
    axes[0][0].plot([], [], ':', color=GREY, label='true natural frequency')
    figure.legend(loc='outside lower center', ncols=4)
    save(
        figure,
        'all_joints_drawn',
        'Figs. 13 and 14 in kind: poles at orders up to 40 (above) and 60, all joints or joint 6',
    )


def main(seed: int = SEED) -> None:
    found = experiments(seed=seed)
    tabulate(found, seed)
    tabulate_modes(found)
    say(
        f'Sensor noise {NOISE_DENSITY:g} (quiet) and {HALL_DENSITY:g} m/s²/√Hz (hall), white and '
        'independent between channels.'
    )
    show_findings(SECTION, findings(found), keep=seed == SEED)
    if seed == SEED:
        draw(found)


if __name__ == '__main__':
    typer.run(main)
