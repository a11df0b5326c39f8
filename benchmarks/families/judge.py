"""What is right and wrong about the modes and lines reported of one record."""

from collections.abc import Sequence
from dataclasses import dataclass, field
import math

import numpy as np
from numpy.typing import NDArray

from benchmarks.families.matching import match, Matched, reach_hz
from benchmarks.families.record import Record
from modal_core.mode import Mode
from modal_core.numbers.indicators import mac

LEAST_SHARE = 0.01
"""Of the response, for a mode to be asked for."""
FEWEST_PERIODS, HIGHEST = 20.0, 0.4
"""Band in which modes are asked for: periods in the record, share of the sample rate."""
PRODUCT_EDGES = (0.5, 2.0)
"""Of the bins of ζ f T."""
LINE_REACH, LINE_LINES = 0.005, 2.0
"""How near a line is: a share of its frequency and lines of the record, whichever is more."""
SIGMAS = 2.0
LARGE_LOSS, SURE_LOSS = 0.1, 0.01
"""Loss of MAC that is a wrong shape, and the expected one of a shape that is said to be right."""


@dataclass
class Verdict:
    """One run, counted; lists hold an entry per mode found that is a true one.

    Parameters
    ----------
    family, seed : str, int
    asked, found : list of int
        Modes (or groups that the record cannot tell apart) asked for by bin of ζ f T; those found.
    modes_as_lines : list of int
        Those missed and reported as a line.
    n_false, n_lines, n_lines_as_modes, n_false_lines : int
        Modes that are none; lines there; reported as modes; lines reported that are none.
    errors : list of [ζ f T, error of f, of ζ over the law, of f, of ζ over the bound]
        Of modes that can be told apart, without drift; NaN where there is no bound.
    inside : list of [f, ζ]
        Whether the error is within 2σ; None without σ.
    shapes : list of [components within 2σ, components]
        Of modes with σ of their shape.
    losses : list of [1 - MAC, expected, within two deviations of it]
        Of modes with a `mac_loss`.
    n_sure_and_wrong : int
        Shapes that are wrong and look sure.
    cpu_s, duration_s : float [s]
    notes : list of str
        What was wrong, in words.
    failed : str
        Why nothing came out.
    """

    family: str
    seed: int
    asked: list[int] = field(default_factory=lambda: [0, 0, 0])
    found: list[int] = field(default_factory=lambda: [0, 0, 0])
    modes_as_lines: list[int] = field(default_factory=lambda: [0, 0, 0])
    n_false: int = 0
    n_lines: int = 0
    n_lines_as_modes: int = 0
    n_false_lines: int = 0
    errors: list[list[float]] = field(default_factory=list)
    inside: list[list[bool | None]] = field(default_factory=list)
    shapes: list[list[int]] = field(default_factory=list)
    losses: list[list[float]] = field(default_factory=list)
    n_sure_and_wrong: int = 0
    cpu_s: float = 0.0
    duration_s: float = 0.0
    notes: list[str] = field(default_factory=list)
    failed: str = ''

    @property
    def n_made_up(self) -> int:
        """Modes that are none, lines among them."""
        return self.n_false + self.n_lines_as_modes


def judge(modes: Sequence[Mode], lines: Sequence[Mode], record: Record) -> Verdict:
    """Hold modes and lines against the truth."""
    verdict = Verdict(record.family, record.seed, duration_s=record.duration_s)
    matched = match(modes, record)
    verdict.n_lines = len(record.lines_hz)
    _count_recall(verdict, matched, lines, record)
    _count_false(verdict, modes, matched, record)
    _count_false_lines(verdict, lines, record)
    for mode, true in zip(modes, matched.true_of, strict=True):
        if true >= 0 and matched.alone[true]:
            _judge_values(verdict, mode, int(true), record)
    return verdict


def product(record: Record) -> NDArray[np.float64]:
    """Return ζ f T of the true modes, T that of a steady force."""
    plant = record.plant
    return np.asarray(plant.damping_ratio * plant.frequency_hz * record.steady_s)


def asked_for(record: Record) -> NDArray[np.bool_]:
    """Tell which true modes are asked for.

    They lie in the band, carry 1 % of the response, and the record tells frequency to a half-width
    and damping to itself.
    """
    hz, zeta = record.plant.frequency_hz, record.plant.damping_ratio
    within = (hz * record.duration_s >= FEWEST_PERIODS) & (hz <= HIGHEST * record.rate_hz)
    told = (record.deviation[0] < zeta) & (record.deviation[1] < 1.0)
    return np.asarray(within & told & (record.share >= LEAST_SHARE))


def _count_recall(
    verdict: Verdict, matched: Matched, lines: Sequence[Mode], record: Record
) -> None:
    asked, bins = asked_for(record), np.digitize(product(record), PRODUCT_EDGES)
    near_hz = np.maximum(reach_hz(record), 1.0 / record.duration_s)
    plant = record.plant
    for group in np.unique(matched.group[asked]):
        members = np.flatnonzero(matched.group == group)
        place = int(bins[members[asked[members]]].max())
        verdict.asked[place] += 1
        if np.isin(members, matched.true_of).any():
            verdict.found[place] += 1
            continue
        mode = int(members[np.argmax(record.share[members])])
        hz = plant.frequency_hz[mode]
        as_line = any(
            abs(line.frequency_hz - hz) < near_hz[mode] and not _on_line(line.frequency_hz, record)
            for line in lines
        )
        verdict.modes_as_lines[place] += as_line
        verdict.notes.append(
            f'{"called a line" if as_line else "missed"}: {hz:.5g} Hz, ζ'
            f' {plant.damping_ratio[mode]:.2%}, share {record.share[mode]:.1%}, ζfT'
            f' {product(record)[mode]:.2g}' + (f' (one of {len(members)})' * (len(members) > 1))
        )


def _on_line(hz: float, record: Record) -> bool:
    return any(
        abs(hz - line) < max(LINE_REACH * line, LINE_LINES / record.duration_s)
        for line in record.lines_hz
    )


def _count_false(
    verdict: Verdict, modes: Sequence[Mode], matched: Matched, record: Record
) -> None:
    for mode, true in zip(modes, matched.true_of, strict=True):
        if true >= 0:
            continue
        on_line = _on_line(mode.frequency_hz, record)
        verdict.n_lines_as_modes += on_line
        verdict.n_false += not on_line
        verdict.notes.append(
            f'{"a line as a mode" if on_line else "false"}: {mode.frequency_hz:.5g} ±'
            f' {mode.frequency_std_hz:.2g} Hz, ζ {mode.damping_ratio:.2%} ±'
            f' {mode.damping_ratio_std:.2%}{_nearest(mode, record)}'
        )


def _nearest(mode: Mode, record: Record) -> str:
    """Describe the true mode that is nearest in frequency over its reach."""
    away = (mode.frequency_hz - record.plant.frequency_hz) / reach_hz(record)
    near = int(np.argmin(np.abs(away)))
    known = np.isfinite(mode.shape)
    alike = float(mac(mode.shape[known], record.plant.shapes[known, near])[0, 0])
    return (
        f'; nearest {record.plant.frequency_hz[near]:.5g} Hz, ζ'
        f' {record.plant.damping_ratio[near]:.2%}: {away[near]:.2g} reaches, MAC {alike:.2f}'
    )


def _count_false_lines(verdict: Verdict, lines: Sequence[Mode], record: Record) -> None:
    false = [line for line in lines if not _on_line(line.frequency_hz, record)]
    verdict.n_false_lines = len(false)
    verdict.notes += [f'line that is none: {line.frequency_hz:.5g} Hz' for line in false]


def _judge_values(verdict: Verdict, mode: Mode, true: int, record: Record) -> None:
    if record.drift:
        return
    plant = record.plant
    least = record.law[:, true]
    errors = []
    inside: list[bool | None] = []
    for what, value, truth, std, limit in (
        ('f', mode.frequency_hz, plant.frequency_hz[true], mode.frequency_std_hz, least[0]),
        ('ζ', mode.damping_ratio, plant.damping_ratio[true], mode.damping_ratio_std, least[1]),
    ):
        error = value - truth
        errors.append(float(error / truth / limit))
        inside.append(bool(abs(error) < SIGMAS * std) if math.isfinite(std) else None)
        if math.isfinite(std) and abs(error) > 2.0 * SIGMAS * std:
            verdict.notes.append(
                f'{what} {value:.5g} ± {std:.2g} for {truth:.5g}: {error / std:.1f} σ, of the law'
                f' {errors[-1]:.1f}'
            )
    bound = np.full(2, math.nan) if record.bound is None else record.bound[:, true]
    of_bound = np.array(errors) * least / bound
    verdict.errors.append([float(product(record)[true]), *errors, *map(float, of_bound)])
    verdict.inside.append(inside)
    _judge_shape(verdict, mode, np.asarray(plant.shapes[:, true], dtype=complex))


def _judge_shape(verdict: Verdict, mode: Mode, truth: NDArray[np.complex128]) -> None:
    known = np.isfinite(mode.shape)
    if known.sum() < 2:
        return
    shape, truth = mode.shape[known], truth[known]
    if mode.shape_std is not None:
        std = mode.shape_std[known]
        error = shape - truth / truth[np.argmax(np.abs(shape))]
        both = np.abs(np.concatenate([error.real, error.imag]))
        limit = SIGMAS * np.concatenate([std.real, std.imag])
        judged = np.isfinite(limit) & (limit > 0.0)
        verdict.shapes.append([int((both < limit)[judged].sum()), int(judged.sum())])
    if not math.isfinite(mode.mac_loss):
        return
    loss = 1.0 - float(mac(shape, truth)[0, 0])
    within = loss <= mode.mac_loss + SIGMAS * mode.mac_loss_std
    verdict.losses.append([loss, mode.mac_loss, float(within)])
    if loss > LARGE_LOSS and mode.mac_loss < SURE_LOSS:
        verdict.n_sure_and_wrong += 1
        verdict.notes.append(
            f'shape wrong and sure: {mode.frequency_hz:.5g} Hz, MAC {1.0 - loss:.2f}, expected'
            f' loss {mode.mac_loss:.2g}'
        )
