"""A map of the workspace from a few poses, on arms that have what their model lacks.

Every figure is over `N_ARMS` arms drawn from seeds that were not used in development, 100 poses
of the whole workspace each, none of them measured.  Measurements have the noise of a minute's
record; no time is simulated (`ama map measure` does that).
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
import time

import numpy as np
from numpy.typing import NDArray

from benchmarks.hidden_arms import hidden_arm, HiddenArm, HIGHEST_HZ, known_arm, RECORD_S
from benchmarks.map_rivals import multi_task_gp, plain_gpr, Predictor, random_forest
from benchmarks.table import Line
from structural_model.scan import random_poses
from workspace_map import candidates, choose_series, receptance, WorkspaceMap
from workspace_map.following import followed_from, followed_ids

Array = NDArray[np.float64]
FIRST_SEED, N_ARMS, N_UNSEEN, N_POSES = 860000, 5, 100, 15
N_CANDIDATES, N_INTEREST, N_TRANSFER = 120, 80, 4
COUNTS, RIVAL_COUNTS = (2, 3, 4, 6, 8), (15, 30, 60)
N_RIVAL_ARMS, N_PATHS, N_STOPS = 3, 3, 8
FRF_HZ = np.linspace(4.0, 55.0, 150)
REACH = 0.01
STEP_RAD = np.deg2rad(2.0)


@dataclass(frozen=True)
class Errors:
    """Of one arm at poses never measured: logarithms of predicted over true, and over σ."""

    frequency: Array
    in_sigma: Array
    damping: Array
    damping_in_sigma: Array
    frac: Array
    seconds: Array

    @property
    def median(self) -> float:
        """Of the frequencies, relative."""
        return float(np.median(np.abs(self.frequency)))


def rows(n_arms: int = N_ARMS, first_seed: int = FIRST_SEED) -> Iterator[Line]:
    """Yield the lines of the table."""
    seeds = range(first_seed, first_seed + n_arms)
    arms = [hidden_arm(seed) for seed in seeds]
    chosen = chosen_poses()
    full = [mapped(arm, chosen[:N_POSES]) for arm in arms]
    errors = [errors_of(known, arm) for known, arm in zip(full, arms, strict=True)]
    yield from _accuracy(errors, arms)
    yield from _poses_needed(arms, chosen)
    yield _ids(full, arms)
    yield _transfer(full, arms)
    milliseconds = 1e3 * np.median(np.concatenate([each.seconds for each in errors]))
    yield Line(
        'prediction at one pose, 15 poses measured, σ included', f'{milliseconds:.1f} ms',
        reach='≤ 5 ms', met=bool(milliseconds <= 5.0),
    )  # fmt: skip


def chosen_poses() -> Array:
    """Return the poses that the map chooses before anything is measured, in order."""
    known = WorkspaceMap(known_arm(), HIGHEST_HZ)
    rng = np.random.default_rng(0)
    limits = known.arm.model.limits
    possible, interest = (random_poses(limits, n, rng) for n in (N_CANDIDATES, N_INTEREST))
    choice = candidates(known, possible, interest, RECORD_S)
    order = choose_series(known, choice, N_POSES, lambda here, q: np.ones(len(q)))
    return possible[order]


def mapped(arm: HiddenArm, poses: Array, before: WorkspaceMap | None = None) -> WorkspaceMap:
    """Return the map of an arm from its modes at some poses."""
    measured = tuple(arm.measured(q, number) for number, q in enumerate(poses))
    return WorkspaceMap(known_arm(), HIGHEST_HZ, measured, before=before)


def random_of(arm: HiddenArm, count: int, purpose: int) -> Array:
    """Return random poses for a purpose: 0 to measure, 1 to judge."""
    rng = np.random.default_rng([arm.seed, purpose])
    return random_poses(arm.model.limits, count, rng)


def errors_of(known: WorkspaceMap, arm: HiddenArm) -> Errors:
    """Compare a map with the arm at poses never measured; modes by rank of frequency."""
    found: list[list[Array]] = [[], [], [], [], [], []]
    known.state(np.zeros(arm.model.n_joints))  # the fit is not part of a prediction
    for q in random_of(arm, N_UNSEEN, 1):
        true_hz, true_ratio, _ = arm.modes(q)
        begin = time.perf_counter()
        modes = known.predict(q)
        spent = time.perf_counter() - begin
        n = min(len(true_hz), len(modes))
        off = np.log(modes.frequency_hz[:n] / true_hz[:n])
        ratio = np.log(modes.damping_ratio[:n] / true_ratio[:n])
        frac = _frac(arm.frf(q, FRF_HZ), receptance(modes, FRF_HZ))
        std = (modes.frequency_std_hz / modes.frequency_hz)[:n]
        ratio_std = (modes.damping_ratio_std / modes.damping_ratio)[:n]
        parts = off, off / std, ratio, ratio / ratio_std, frac, np.array([spent])
        for kept, part in zip(found, parts, strict=True):
            kept.append(part)
    return Errors(*(np.concatenate(each) for each in found))


def _frac(true: Array, found: Array) -> Array:
    """Return |Σ a* b|² / (Σ|a|² Σ|b|²) of the whole 3 x 3 response along frequency."""
    product = np.abs(np.sum(true.conj() * found)) ** 2
    return np.array([product / (np.sum(np.abs(true) ** 2) * np.sum(np.abs(found) ** 2))])


def _accuracy(errors: list[Errors], arms: list[HiddenArm]) -> Iterator[Line]:
    median = np.median([each.median for each in errors])
    model = known_arm().model
    of_model = []
    for arm in arms:
        for q in random_of(arm, N_UNSEEN // 5, 1):
            true_hz = arm.modes(q)[0]
            of_model += list(np.log(model.modes(q).frequency_hz[: len(true_hz)] / true_hz))
    what = f'{N_POSES} poses chosen by itself, {N_UNSEEN} unseen poses, {len(arms)} arms'
    yield Line(
        f'{what}: error of f, median of arms (model alone as peer)', f'{100 * median:.2f} %',
        f'{100 * np.median(np.abs(of_model)):.1f} %', reach='≤ 1 %', met=bool(median <= REACH),
    )  # fmt: skip
    worst = max(each.median for each in errors)
    yield Line('the same, the arm that is mapped worst', f'{100 * worst:.2f} %')
    off = np.abs(np.concatenate([each.frequency for each in errors]))
    yield Line('the same, 95 % of all modes', f'{100 * np.quantile(off, 0.95):.1f} %')
    inside = np.mean(np.abs(np.concatenate([each.in_sigma for each in errors])) < 2.0)
    yield Line(
        'true f within 2σ', f'{100 * inside:.1f} %', reach='93 to 97 %',
        met=bool(0.93 <= inside <= 0.97),
    )  # fmt: skip
    ratio = np.median(np.abs(np.expm1(np.concatenate([each.damping for each in errors]))))
    yield Line(
        'error of damping, median', f'{100 * ratio:.1f} %', reach='≤ 15 %', met=bool(ratio <= 0.15)
    )
    inside = np.mean(np.abs(np.concatenate([each.damping_in_sigma for each in errors])) < 2.0)
    yield Line('true damping within 2σ', f'{100 * inside:.1f} %')
    frac = np.median(np.concatenate([each.frac for each in errors]))
    yield Line(
        'FRAC of the 3 x 3 tool-point response, 4 to 55 Hz, median', f'{frac:.3f}',
        reach='≥ 0.95', met=bool(frac >= 0.95),
    )  # fmt: skip


def _poses_needed(arms: list[HiddenArm], chosen: Array) -> Iterator[Line]:
    def of(poses: Callable[[HiddenArm, int], Array]) -> dict[int, float]:
        return {
            count: float(
                np.median([errors_of(mapped(arm, poses(arm, count)), arm).median for arm in few])
            )
            for count in COUNTS
        }

    few = arms[:N_RIVAL_ARMS]
    own = of(lambda arm, count: chosen[:count])
    by_chance = of(lambda arm, count: random_of(arm, count, 0))
    mine = _needed(own)
    yield Line(f'poses needed for a median of 1 %, {len(few)} arms, chosen', _words(own, mine))
    yield _against('the same map, random poses', mine, by_chance)
    for name, method in (
        ('plain GPR', plain_gpr),
        ('random forest', random_forest),
        ('multi-task GP', multi_task_gp),
    ):
        found = {n: float(np.median([_rival(method, arm, n) for arm in few]))
                 for n in RIVAL_COUNTS}  # fmt: skip
        yield _against(f'{name}, random poses', mine, found)


def _needed(errors: dict[int, float]) -> int | None:
    """Return the fewest poses from which on the error stays within reach."""
    counts = sorted(errors, reverse=True)
    found = None
    for count in counts:
        if errors[count] > REACH:
            break
        found = count
    return found


def _against(what: str, mine: int | None, errors: dict[int, float]) -> Line:
    theirs = _needed(errors)
    least = theirs or 2 * max(errors)
    ratio = None if mine is None else mine / least
    return Line(
        f'poses needed, ours chosen against {what}', str(mine), _words(errors, theirs),
        '-' if ratio is None else f'{ratio:.2f}', '≤ 0.5', ratio is not None and ratio <= 0.5,
    )  # fmt: skip


def _words(errors: dict[int, float], needed: int | None) -> str:
    each = ', '.join(f'{count}: {100 * error:.2f} %' for count, error in errors.items())
    return f'{needed or f"more than {max(errors)}"} ({each})'


def _rival(method: Callable[[Array, Array, Array], Predictor], arm: HiddenArm, n: int) -> float:
    """Return the median error of a method; of the modes that every pose has."""
    poses, unseen = random_of(arm, n, 0), random_of(arm, N_UNSEEN, 1)
    measured = [arm.measured(q, number) for number, q in enumerate(poses)]
    true = [arm.modes(q)[0] for q in unseen]
    count = min(*(len(each) for each in measured), *(len(each) for each in true))
    log_f = np.log([each.frequency_hz[:count] for each in measured])
    std = np.array([(e.frequency_std_hz / e.frequency_hz)[:count] for e in measured])
    off = method(poses, log_f, std)(unseen) - np.log([each[:count] for each in true])
    return float(np.median(np.abs(off)))


def _ids(maps: list[WorkspaceMap], arms: list[HiddenArm]) -> Line:
    """Follow measured modes along straight paths between poses of the workspace."""
    right = crossed = crossed_right = total = 0
    for known, arm in zip(maps, arms, strict=True):
        ends = random_of(arm, 2 * N_PATHS, 2).reshape(N_PATHS, 2, -1)
        for start, end in ends:
            for true, found in _along(known, arm, start, end):
                same = true == found
                moved = true != np.arange(1, len(true) + 1)
                total, right = total + len(true), right + int(same.sum())
                crossed += int(moved.sum())
                crossed_right += int(same[moved].sum())
    share = right / max(total, 1)
    return Line(
        f'ids right along {N_PATHS * len(arms)} paths through the workspace'
        f' ({crossed_right} of {crossed} of modes that changed places)',
        f'{100 * share:.1f} % of {total}', reach='≥ 99 %', met=share >= 0.99,
    )  # fmt: skip


def _along(
    known: WorkspaceMap, arm: HiddenArm, start: Array, end: Array
) -> Iterator[tuple[Array, Array]]:
    """Yield true and found ids of the measured modes at stops of a path."""
    here = followed_from(known, start)
    shapes = arm.at(start).modes(start).shapes
    ids, last = np.arange(1, len(shapes) + 1), start
    for number, part in enumerate(np.linspace(0.0, 1.0, N_STOPS)):
        q = start + part * (end - start)
        count = max(1, int(np.ceil(np.max(np.abs(q - last)) / STEP_RAD)))
        for step in range(1, count + 1):
            there = last + (q - last) * step / count
            newer = arm.at(there).modes(there).shapes
            shapes, ids = newer, followed_ids(shapes, ids, newer)
        here, last = here.moved(q), q
        measured = arm.measured(q, number)
        yield ids[: len(measured)], here.ids_of(measured)


def _transfer(maps: list[WorkspaceMap], arms: list[HiddenArm]) -> Line:
    """Map an arm of the same make from four poses and the other's map, or from 15 of its own."""
    poses = chosen_poses()
    ratios, own, alone = [], [], []
    for known, arm in zip(maps[:N_RIVAL_ARMS], arms[:N_RIVAL_ARMS], strict=True):
        other = hidden_arm(arm.seed, sibling=1)
        few = errors_of(mapped(other, poses[:N_TRANSFER], before=known), other).median
        own.append(errors_of(mapped(other, poses[:N_POSES]), other).median)
        alone.append(errors_of(mapped(other, poses[:N_TRANSFER]), other).median)
        ratios.append(few / own[-1])
    median = float(np.median(ratios))
    return Line(
        f'transfer to an arm of the same make, {N_TRANSFER} poses: error over that of'
        f' {N_POSES} poses of its own (peer: {N_TRANSFER} poses without the other map)',
        f'{median:.2f}', f'{np.median(np.divide(alone, own)):.2f}', reach='≤ 1.3',
        met=median <= 1.3,
    )  # fmt: skip
