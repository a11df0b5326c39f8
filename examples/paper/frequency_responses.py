"""Figs. 2 and 4-6, Tables 1 and 3-5: responses of the spindle at twelve postures.

The paper hits the arm with a hammer; here its own drives shake it, so that a response is the
spindle's acceleration per acceleration of a drive, measured from encoders and accelerometers.

Run ``python -m examples.paper.frequency_responses``.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
import typer

from examples.paper.cell import (
    identify,
    matched,
    plan_pulses,
    Record,
    ROBOT,
    robot,
    SAMPLE_RATE_HZ,
    shake,
    STILL_NOISE,
    Truth,
    truth,
)
from examples.paper.drawing import COLOURS, INK, panels, save
from examples.paper.output import (
    Finding,
    NOT_REPRODUCED,
    PARTLY,
    REPRODUCED,
    show_findings,
    show_table,
)
from modal_core.channel import Channel
from modal_core.measurements import JointSamples
from modal_core.mode import Mode
from structural_model import load_layout
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
SEED = 2025
DURATION_S = 60.0
SECTION = '2 Frequency responses'
REGIONS = ('P1', 'P2', 'P3')
STEPS_DEG = (0.0, 5.0, 10.0, 15.0)
# Segments of the averages: 0.25 Hz apart.
SEGMENT_S = 4.0
# The link that carries the spindle and its sensor.
LINK = 'flange'
# Direction in the base frame, and the axis whose drive moves the spindle that way at zero pose.
DIRECTIONS = {'X': (0, 'axis_2'), 'Y': (1, 'axis_1')}
# Below the first frequency the plan moves little; above the last the drives do not follow.
LOWEST_HZ, HIGHEST_HZ = 8.0, 60.0
# All axes equally strong, so that each drive's response stands out of the others'.
EVEN = {'require_full_rank': False}
N_LISTED = 4


@dataclass(frozen=True)
class Posture:
    """One posture: its responses measured and of the model, (n_frequencies, 3, 6), and modes."""

    pose: str
    step_deg: float
    frequency_hz: Array
    measured: Complex
    model: Complex
    pairs: dict[int, Mode]
    truth: Truth

    def off_db(self, direction: str) -> float:
        """Return how far the measured response is from the model's, median [dB]."""
        ratio = self.of(direction, self.measured) / self.of(direction, self.model)
        return float(np.median(np.abs(20.0 * np.log10(ratio))))

    def of(self, direction: str, response: Complex) -> Array:
        """Return the magnitude of the response drawn for a direction [m/s² per rad/s²]."""
        row, axis = DIRECTIONS[direction]
        return np.abs(response[:, row, int(axis[-1]) - 1])


def posture(model: FlexibleJointModel, pose: str, step_deg: float, seed: int = SEED) -> Posture:
    """Shake the arm about one posture, once for its responses and once for its modes."""
    even, best = (
        shake(model, plan_pulses(model, pose, step_deg, step_deg, seed, DURATION_S, **noise), seed)
        for noise in ({**STILL_NOISE, **EVEN}, STILL_NOISE)
    )
    frequency_hz, found = measured_response(model, even)
    real = truth(model, best, n_poses=2)
    return Posture(
        pose,
        step_deg,
        frequency_hz,
        found,
        model_response(model, even.plan.start_position, frequency_hz),
        matched(identify(best).modes.modes, real),
        real,
    )


def measured_response(model: FlexibleJointModel, record: Record) -> tuple[Array, Complex]:
    """Return frequencies and the response of the spindle to all drives.

    The planned motion is free of the encoders' noise, which would make the response too small: it
    is the instrument that both sides are correlated with.

    Returns
    -------
    tuple of (n_frequencies,) and (n_frequencies, 3, 6) array
        Base axes by controller axes.

    References
    ----------
    Pintelon and Schoukens (2012), System Identification, Sect. 2.7: H = G_rx⁻¹ G_ry.
    """
    encoders = [part for part in record.measurements if isinstance(part, JointSamples)]
    stamps = np.concatenate([part.stamp_ns for part in encoders])
    rate_hz = 1e9 * (len(stamps) - 1) / float(stamps[-1] - stamps[0])
    angle = model.to_controller(record.position)
    drives = np.diff(angle, 2, axis=0) * rate_hz**2
    columns = [channel in _spindle() for channel in load_layout(ROBOT).channels]
    # What is differenced twice stands in the middle: from the second stamp on.
    x = _segments(drives, rate_hz, 1e-9 * stamps[1])
    y = _segments(record.acceleration[:, columns], SAMPLE_RATE_HZ, 1.0 / SAMPLE_RATE_HZ)
    planned = record.plan.trajectory
    r = _segments(model.to_controller(planned.acceleration), 1.0 / planned.sample_period_s, 0.0)
    frequency_hz = np.arange(x.shape[1]) / SEGMENT_S
    inside = np.flatnonzero((frequency_hz >= LOWEST_HZ) & (frequency_hz <= HIGHEST_HZ))
    n_segments = min(map(len, (r, x, y)))
    r, x, y = (part[:n_segments, inside] for part in (r, x, y))
    frequency_hz = frequency_hz[inside]
    # Second differences of a sine are smaller than its second derivative.
    phase = 2.0 * np.pi * frequency_hz / rate_hz
    x = x * (phase**2 / (2.0 - 2.0 * np.cos(phase)))[:, None]
    inputs, outputs = (np.einsum('sfi,sfj->fij', r.conj(), part) for part in (x, y))
    response = np.linalg.solve(inputs, outputs).transpose(0, 2, 1)
    return frequency_hz, _turn(model, record.plan.start_position) @ response


def model_response(model: FlexibleJointModel, q: Array, frequency_hz: Array) -> Complex:
    """Return the same response of the model: rigid motion, springs and tilt in gravity."""
    system = model.state_space(q, _spindle())
    drives = model.to_serial(np.eye(model.n_joints)).T
    axis = 2j * np.pi * frequency_hz[:, None, None] * np.eye(len(system.A))
    states = np.linalg.solve(
        axis - system.A, np.broadcast_to(system.B, (len(axis), *system.B.shape))
    )
    return np.asarray(_turn(model, q) @ (system.C @ states + system.D) @ drives)


def _spindle() -> list[Channel]:
    return [channel for channel in load_layout(ROBOT).channels if channel.frame_id == LINK]


def _segments(samples: Array, rate_hz: float, first_s: float) -> Complex:
    """Return the spectra of half overlapping segments, (n_segments, n_frequencies, n)."""
    length = round(SEGMENT_S * rate_hz)
    window = np.hanning(length + 1)[:-1, None]
    starts = range(0, len(samples) - length + 1, length // 2)
    parts = [np.fft.rfft(window * samples[start : start + length], axis=0) for start in starts]
    turn = np.exp(-2j * np.pi * np.arange(length // 2 + 1) / SEGMENT_S * first_s)
    return np.asarray(parts) / length * turn[:, None]


def _turn(model: FlexibleJointModel, q: Array) -> Array:
    """Return the axes of the spindle's sensor in the base frame, as columns."""
    joint, placement = model.assembly.link(LINK)
    return np.asarray(model.kinematics.motion(q).rotation[0, joint] @ placement.rotation)


def tabulate(found: list[Posture], keep: str) -> None:
    rows = []
    for each in found:
        listed = [each.pairs.get(index) for index in range(N_LISTED)]
        rows.append(
            (
                f'{each.pose} +{each.step_deg:g}°',
                ' '.join(f'{hz:.2f}' for hz in each.truth.frequency_hz[:N_LISTED]),
                ' '.join('-' if m is None else f'{m.frequency_hz:.2f}' for m in listed),
                ' '.join('-' if m is None else f'{100 * m.damping_ratio:.1f}' for m in listed),
                f'{len(each.pairs)} of {len(each.truth.frequency_hz)}',
                *(f'{each.off_db(direction):.1f}' for direction in DIRECTIONS),
            )
        )
    show_table(
        f'Tables 1, 3-5 in kind: first {N_LISTED} modes; {DURATION_S:g} s of noise, seed {SEED}',
        ('posture', 'true [Hz]', 'identified [Hz]', 'damping [%]', 'modes', 'X off [dB]', 'Y'),
        rows,
        keep=keep,
    )


def findings(found: list[Posture]) -> list[Finding]:
    """Return what became of Figs. 2 and 4-6."""
    off = [each.off_db(direction) for each in found for direction in DIRECTIONS]
    n_true = sum(len(each.truth.frequency_hz) for each in found)
    n_found = sum(len(each.pairs) for each in found)
    changes = zip(REGIONS, _largest_changes(found), strict=True)
    moved = [f'{100.0 * change:.1f} % at {pose}' for pose, change in changes]
    kept = all(
        sorted(each.pairs) == sorted(each.pairs, key=lambda i, p=each.pairs: p[i].frequency_hz)
        for each in found
    )
    all_first = all(each.pairs.keys() >= set(range(N_LISTED)) for each in found)
    return [
        Finding(
            'Tables 1, 3-5: the first four modes are identified at every posture',
            f'{n_found} of all {n_true} modes at {len(found)} postures; measured responses are'
            f" {np.median(off):.1f} dB from the model's (at worst {max(off):.1f} dB)",
            REPRODUCED if all_first else PARTLY,
        ),
        Finding(
            'Figs. 4-6: frequencies move with the posture, the order of the modes stays',
            f'by up to {", ".join(moved)}: in {"the same" if kept else "another"} order',
            REPRODUCED if kept else NOT_REPRODUCED,
        ),
    ]  # fmt: skip


def _largest_changes(found: list[Posture]) -> list[float]:
    """Return the largest change of an identified frequency in each region, relative."""
    changes = []
    for pose in REGIONS:
        first, *others = (each.pairs for each in found if each.pose == pose)
        changes.append(
            max(
                abs(other[i].frequency_hz / first[i].frequency_hz - 1.0)
                for other in others
                for i in first.keys() & other.keys()
            )
        )
    return changes


def draw_poses(found: list[Posture]) -> None:
    """Draw Fig. 2: the three poses, one panel a direction."""
    figure, axes = panels(1, len(DIRECTIONS), (9.5, 3.6))
    at_poses = [each for each in found if each.step_deg == 0.0]
    for axis, (direction, (_, drive)) in zip(axes[0], DIRECTIONS.items(), strict=True):
        for each, colour in zip(at_poses, COLOURS, strict=False):
            measured, model = (each.of(direction, r) for r in (each.measured, each.model))
            axis.semilogy(each.frequency_hz, measured, color=colour, lw=1.4, label=each.pose)
            axis.semilogy(each.frequency_hz, model, color=INK, lw=0.8, ls=(0, (2, 2)))
        axis.set(xlabel='frequency [Hz]', xlim=(LOWEST_HZ, HIGHEST_HZ))
        axis.set_title(
            f'({"ab"[direction == "Y"]}) {direction}, by the drive of {drive.replace("_", " ")}'
        )
    axes[0][0].set_ylabel('spindle / drive [m/s² per rad/s²]')
    axes[0][0].plot([], [], color=INK, lw=0.8, ls=(0, (2, 2)), label='model')
    figure.legend(*axes[0][0].get_legend_handles_labels(), loc='outside lower center', ncols=4)
    save(figure, 'frf_drawn', 'Fig. 2 in kind: responses of the spindle at P1, P2 and P3')


def draw_postures(found: list[Posture]) -> None:
    """Draw Figs. 4-6: four postures of each region, one above the other."""
    figure, axes = panels(len(REGIONS), len(DIRECTIONS), (9.5, 9.0))
    for row, pose in enumerate(REGIONS):
        here = [each for each in found if each.pose == pose]
        for axis, direction in zip(axes[row], DIRECTIONS, strict=True):
            for number, each in enumerate(here):
                lifted = 10.0 ** (1.0 * number)
                measured, model = (
                    lifted * each.of(direction, r) for r in (each.measured, each.model)
                )
                axis.semilogy(each.frequency_hz, measured, color=COLOURS[row], lw=1.4)
                axis.semilogy(each.frequency_hz, model, color=INK, lw=0.8, ls=(0, (2, 2)))
                axis.annotate(
                    f'+{each.step_deg:g}°',
                    (HIGHEST_HZ, model[-1]),
                    xytext=(4, 0),
                    textcoords='offset points',
                    va='center',
                )
            axis.set(xlim=(LOWEST_HZ, HIGHEST_HZ))
            axis.set_title(f'Fig. {4 + row} in kind: {pose}, {direction}')
        axes[row][0].set_ylabel('each posture 10 times the last')
    for axis in axes[-1]:
        axis.set_xlabel('frequency [Hz]')
    axes[0][0].plot([], [], color=INK, lw=1.4, label='measured (colour)')
    axes[0][0].plot([], [], color=INK, lw=0.8, ls=(0, (2, 2)), label='model')
    figure.legend(loc='outside lower center', ncols=2)
    save(
        figure,
        'frf_postures_drawn',
        'Figs. 4 to 6 in kind: responses of the spindle while all axes turn by 5 degrees each',
    )


def main(seed: int = SEED) -> None:
    model = robot()
    found = [posture(model, pose, step, seed) for pose in REGIONS for step in STEPS_DEG]
    tabulate(found, 'frf' if seed == SEED else '')
    show_findings(SECTION, findings(found), keep=seed == SEED)
    if seed == SEED:
        draw_poses(found)
        draw_postures(found)


if __name__ == '__main__':
    typer.run(main)
