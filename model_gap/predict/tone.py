"""Lines of machines: a force at one place whose amplitude and phase are free in every record."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from modal_core.channel import AXES, Channel
from model_gap.campaign import RecordSpectra
from model_gap.cell import joint_vector, PoseSystem, Tone
from model_gap.predict.thresholds import PREDICTION
from structural_model import FlexibleJointModel

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

# (n_dof, 3 n_bins) deflections -> (n_channels, n_bins) readings
Reading = Callable[[Complex], Complex]


def tone_motions(
    tones: Sequence[Tone], item: RecordSpectra, system: PoseSystem, model: FlexibleJointModel
) -> list[Complex]:
    """Return deflections per unit of every free number, for each kind of machine.

    Returns
    -------
    list of (n_free, n_dof, 3 n_bins) complex array
        Switched on as the record begins, running all along, wandering.
    """
    kinds: list[list[Complex]] = [[], [], []]
    length_s = len(item.record.acceleration) / item.record.sample_rate_hz
    for tone in tones:
        pushes = _pushes(tone, item, system, model)
        for line_hz in tone.lines_hz:
            omega = 2.0 * np.pi * line_hz
            for push in pushes.T:
                kinds[0] += _line(omega, push, item, system, length_s, at_rest=True)
                kinds[1] += _line(omega, push, item, system, length_s)
                for number in PREDICTION.line_neighbours:
                    near = omega + 2.0 * np.pi * number / length_s
                    kinds[2] += _line(near, push, item, system, length_s)
    return [np.array(kind) for kind in kinds]


def follow(patterns: Array, rest: Array) -> Array:
    """Return the free numbers that fit a residual best.

    Parameters
    ----------
    patterns : (n_free, n_rows) array
        Readings per unit, real rows over noise.
    rest : (n_rows,) array
        Residual alike.
    """
    gram = patterns @ patterns.T
    gram[np.diag_indices_from(gram)] += PREDICTION.line_ridge * max(float(np.trace(gram)), 1e-300)
    return np.asarray(np.linalg.solve(gram, patterns @ rest))


def best_motion(
    tones: Sequence[Tone],
    kinds: Sequence[Complex],
    item: RecordSpectra,
    reading: Reading,
    rest: Complex,
) -> tuple[Complex, Array]:
    """Return the motion that fits a residual best, and the readings of its kind per unit.

    Of the kinds of machine the one with the least n log S + k log n is taken, S the sum of squares
    near the lines.  Source: Schwarz (1978), doi:10.1214/aos/1176344136.

    Parameters
    ----------
    tones, kinds
        As of :func:`tone_motions`.
    item : RecordSpectra
        The record.
    reading : callable
        What sensors make of deflections.
    rest : (n_channels, n_bins) complex array
        Residual without tones.

    Returns
    -------
    motion : (n_dof, 3 n_bins) complex array
    patterns : (n_free, n_rows) array
    """
    near = near_lines(tones, item)
    wanted = rows_of(rest, item)
    chosen = np.tile((near & item.seen).ravel(), 2)
    count = int(chosen.sum())
    best, found = np.inf, (np.zeros_like(kinds[0][0]), np.zeros((0, len(wanted))))
    for motions in kinds:
        patterns = np.array([rows_of(reading(motion), item) for motion in motions])
        numbers = follow(patterns, wanted)
        left = float(np.sum((wanted - numbers @ patterns)[chosen] ** 2))
        score = count * np.log(max(left, 1e-300)) + len(numbers) * np.log(max(count, 1))
        if score < best:
            best, found = score, (np.tensordot(numbers, motions, 1), patterns)
    return found


def near_lines(tones: Sequence[Tone], item: RecordSpectra) -> NDArray[np.bool_]:
    """Return which bins lie on a line, (n_bins,)."""
    width = float(item.omega[0, 1] - item.omega[0, 0])
    lines = 2.0 * np.pi * np.array([line for tone in tones for line in tone.lines_hz])
    away = np.abs(item.omega[:, 1] - lines[:, None])
    return np.asarray((away < PREDICTION.line_bins * width).any(axis=0))


def rows_of(spectra: Complex, item: RecordSpectra) -> Array:
    """Return spectra over noise as one real vector."""
    scaled = item.over_noise(spectra).ravel()
    return np.concatenate([scaled.real, scaled.imag])


def _line(
    omega: float,
    push: Array,
    item: RecordSpectra,
    system: PoseSystem,
    length_s: float,
    at_rest: bool = False,
) -> list[Complex]:
    """Return the deflection under push·cos(ωt) and -push·sin(ωt), (n_dof, 3 n_bins) each.

    Modes carry z(T) - z(0) out of the record: (iω - λ)Z = G - z(T) + z(0).
    """
    bins = item.omega.ravel()
    drive = system.drives @ push
    steady = drive / (1j * omega - system.poles), drive / (-1j * omega - system.poles)
    turn = np.exp(1j * omega * length_s)
    rung = np.exp(system.poles * length_s) if at_rest else np.ones(len(drive))
    carried = steady[0] * (turn - rung), steady[1] * (np.conj(turn) - rung)
    force = _truncated(bins - omega, length_s), _truncated(bins + omega, length_s)
    return [
        item.end_scale
        * system.deflection(
            bins,
            np.outer(push, 0.5 * (phase * force[0] + np.conj(phase) * force[1])),
            0.5 * (phase * carried[0] + np.conj(phase) * carried[1]),
        )
        for phase in (1.0 + 0.0j, 1.0j)
    ]


def _truncated(offset: Array, length_s: float) -> Complex:
    """Return ∫ exp(-i x t) dt over the record."""
    half = offset * length_s / 2.0
    return np.asarray(length_s * np.exp(-1j * half) * np.sinc(half / np.pi))


def _pushes(
    tone: Tone, item: RecordSpectra, system: PoseSystem, model: FlexibleJointModel
) -> Array:
    """Return unit loads on the degrees of freedom as columns."""
    if not tone.force:
        return joint_vector(model, tone.place, system.dof_names)[:, None]
    axes = tuple(
        Channel(f'{tone.place}.{axis}', tone.place, direction) for axis, direction in AXES.items()
    )
    rows = model.sensor_jacobian(item.record.pose, axes)
    if rows.shape[1] == len(system.dof_names):
        return np.asarray(rows.T)
    full = np.zeros((len(system.dof_names), 3))  # effects may have added degrees of freedom
    for column, name in enumerate(model.dof_names):
        full[system.dof_names.index(name)] = rows[:, column]
    return full
