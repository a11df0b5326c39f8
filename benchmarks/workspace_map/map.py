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
from scipy.optimize import linear_sum_assignment

from benchmarks.table import Line
from benchmarks.workspace_map.hidden_arms import (
    hidden_arm,
    HiddenArm,
    HIGHEST_HZ,
    known_arm,
    RECORD_S,
)
from benchmarks.workspace_map.rivals import multi_task_gp, plain_gpr, Predictor, random_forest
from structural_model.equations import random_poses
from workspace_map import (
    candidates,
    Carried,
    carried_on,
    choose_series,
    followed_from,
    receptance,
    WorkspaceMap,
)
from workspace_map.fit import BEYOND_BAND

Array = NDArray[np.float64]
FIRST_SEED, N_ARMS, N_UNSEEN, N_POSES = 861000, 16, 100, 15
N_CANDIDATES, N_INTEREST, N_TRANSFER = 120, 80, 4
COUNTS, RIVAL_COUNTS = (2, 3, 4, 8, 15), (15, 30, 60)
N_RIVAL_ARMS, N_PATHS, N_STOPS, FEW_UNSEEN = 3, 3, 8, 40
N_PATH_ARMS, N_TRANSFER_ARMS = 5, 8
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

    @property
    def most(self) -> float:
        """What 95 % of the frequencies of the workspace keep, relative."""
        return float(np.quantile(np.abs(self.frequency), 0.95))


def rows(n_arms: int = N_ARMS, first_seed: int = FIRST_SEED) -> Iterator[Line]:
    """Yield the lines of the table."""
    seeds = range(first_seed, first_seed + n_arms)
    arms = [hidden_arm(seed) for seed in seeds]
    chosen = chosen_poses()
    full = [mapped(arm, chosen[:N_POSES]) for arm in arms]
    errors = [errors_of(known, arm) for known, arm in zip(full, arms, strict=True)]
    yield from _accuracy(errors, arms)
    yield from _poses_needed(arms, chosen)
    yield from _ids(full[:N_PATH_ARMS], arms[:N_PATH_ARMS])
    yield _transfer(full, arms)
    milliseconds = 1e3 * np.median(np.concatenate([each.seconds for each in errors]))
    yield Line(
        'prediction at one pose, 15 poses measured, σ included, processor time',
        f'{milliseconds:.1f} ms', reach='≤ 5 ms', met=bool(milliseconds <= 5.0),
    )  # fmt: skip


def chosen_poses(count: int = N_POSES, before: WorkspaceMap | None = None) -> Array:
    """Return the poses that the map chooses before this arm is measured, in order."""
    known = WorkspaceMap(known_arm(), HIGHEST_HZ, before=before)
    rng = np.random.default_rng(0)
    limits = known.arm.model.limits
    possible, interest = (random_poses(limits, n, rng) for n in (N_CANDIDATES, N_INTEREST))
    choice = candidates(known, possible, interest, RECORD_S)
    order = choose_series(known, choice, count, lambda here, q: np.ones(len(q)))
    return possible[order]


def mapped(arm: HiddenArm, poses: Array, before: WorkspaceMap | None = None) -> WorkspaceMap:
    """Return the map of an arm from its modes at some poses."""
    measured = tuple(arm.measured(q, number) for number, q in enumerate(poses))
    return WorkspaceMap(known_arm(), HIGHEST_HZ, measured, before=before)


def random_of(arm: HiddenArm, count: int, purpose: int) -> Array:
    """Return random poses for a purpose: 0 to measure, 1 to judge."""
    rng = np.random.default_rng([arm.seed, purpose])
    return random_poses(arm.model.limits, count, rng)


def errors_of(known: WorkspaceMap, arm: HiddenArm, n_unseen: int = N_UNSEEN) -> Errors:
    """Compare a map with the arm at poses never measured; modes by rank of frequency."""
    found: list[list[Array]] = [[], [], [], [], [], []]
    known.state(np.zeros(arm.model.n_joints))  # the fit is not part of a prediction
    for q in random_of(arm, n_unseen, 1):
        true_hz, true_ratio, _ = arm.modes(q)
        begin = time.process_time()
        modes = known.predict(q)
        spent = time.process_time() - begin
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
    def of(poses: Callable[[HiddenArm, int], Array]) -> dict[int, list[Errors]]:
        return {
            count: [errors_of(mapped(arm, poses(arm, count)), arm, FEW_UNSEEN) for arm in few]
            for count in COUNTS
        }

    few = arms[:N_RIVAL_ARMS]
    own = of(lambda arm, count: chosen[:count])
    by_chance = of(lambda arm, count: random_of(arm, count, 0))
    mine = _needed(_median(own))
    words = _words(_median(own), mine)
    yield Line(f'poses needed for a median of 1 %, {len(few)} arms, chosen', words)
    yield _against('the same map, random poses', mine, _median(by_chance))
    all_mine = _needed(_most(own))
    words = _words(_most(own), all_mine)
    yield Line('poses needed for 1 % in 95 % of all modes of the workspace, chosen', words)
    yield _against('the same map, random poses, 95 % of all modes', all_mine, _most(by_chance))
    for name, method in (
        ('plain GPR', plain_gpr),
        ('random forest', random_forest),
        ('multi-task GP', multi_task_gp),
    ):
        found = {n: float(np.median([_rival(method, arm, n) for arm in few]))
                 for n in RIVAL_COUNTS}  # fmt: skip
        yield _against(f'{name}, random poses', mine, found)


def _median(errors: dict[int, list[Errors]]) -> dict[int, float]:
    return {n: float(np.median([each.median for each in of])) for n, of in errors.items()}


def _most(errors: dict[int, list[Errors]]) -> dict[int, float]:
    return {n: float(np.median([each.most for each in of])) for n, of in errors.items()}


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
        f'poses needed, ours chosen against {what}', str(mine or '-'), _words(errors, theirs),
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


def _ids(maps: list[WorkspaceMap], arms: list[HiddenArm]) -> Iterator[Line]:
    """Follow measured modes along straight paths between poses of the workspace."""
    true, found, sure, rank = (
        np.concatenate(each)
        for each in zip(
            *(
                stop
                for known, arm in zip(maps, arms, strict=True)
                for start, end in random_of(arm, 2 * N_PATHS, 2).reshape(N_PATHS, 2, -1)
                for stop in _along(known, arm, start, end)
            ),
            strict=True,
        )
    )
    same, crossed = true == found, true != rank
    share = np.mean(same[sure])
    yield Line(
        f'ids that are stated right along {N_PATHS * len(arms)} paths through the workspace'
        f' ({np.sum(same & sure & crossed)} of {np.sum(sure & crossed)} of modes that changed'
        ' places)',
        f'{100 * share:.1f} % of {sure.sum()}', reach='≥ 99 %', met=bool(share >= 0.99),
    )  # fmt: skip
    yield Line(
        f'the same, undecided (the likelier one right: {np.sum(same & ~sure)} of'
        f' {np.sum(~sure)}; all that is likeliest right: {100 * np.mean(same):.1f} %)',
        f'{100 * np.mean(~sure):.1f} % of {len(sure)}',
    )  # fmt: skip


@dataclass(frozen=True)
class _TrueModes:
    """Modes of the arm itself, somewhat beyond the band."""

    frequency_hz: Array
    damping_ratio: Array
    shapes: Array

    @classmethod
    def at(cls, arm: HiddenArm, q: Array) -> '_TrueModes':
        modes = arm.at(q).modes(q)
        n = int(np.searchsorted(modes.frequency_hz, BEYOND_BAND * HIGHEST_HZ))
        return cls(modes.frequency_hz[:n], modes.damping_ratio[:n], modes.shapes)


def _along(
    known: WorkspaceMap, arm: HiddenArm, start: Array, end: Array
) -> Iterator[tuple[Array, Array, Array, Array]]:
    """Yield true ids, found ids, which are sure and ranks of the measured modes at stops.

    The true id of a mode is that whose shape, carried along the arm's own modes, it has most of,
    however narrowly.
    """
    here, last = followed_from(known, start, arm.measured(start, 0)), start
    modes = _TrueModes.at(arm, start)
    carried, ids = Carried.of(modes), np.arange(1, len(modes.frequency_hz) + 1)
    for number, part in enumerate(np.linspace(0.0, 1.0, N_STOPS)):
        q = start + part * (end - start)
        count = int(np.ceil(np.max(np.abs(q - last)) / STEP_RAD))
        for step in range(1, count + 1):
            modes = _TrueModes.at(arm, last + (q - last) * step / count)
            came, carried = carried_on(carried, modes)
            ids = np.where(came < 0, 0, ids[came])
        here, last = here.moved(q) if number else here, q
        measured = arm.measured(q, number)
        like = np.linalg.solve(modes.shapes, carried.shapes) ** 2
        rows, columns = linear_sum_assignment(-like)
        true = np.zeros(len(like), dtype=np.intp)
        true[rows] = ids[columns]
        named = here.named(measured)
        n = len(measured)
        yield true[:n], named.ids, named.sure, np.arange(1, n + 1)


def _transfer(maps: list[WorkspaceMap], arms: list[HiddenArm]) -> Line:
    """Map an arm of the same make from four poses and the other's map, or from 15 of its own."""
    poses = chosen_poses()
    ratios, one_more, alone, inside = [], [], [], []
    for known, arm in zip(maps[:N_TRANSFER_ARMS], arms[:N_TRANSFER_ARMS], strict=True):
        other = hidden_arm(arm.seed, sibling=1)
        best = chosen_poses(N_TRANSFER + 1, known)
        own = errors_of(mapped(other, poses[:N_POSES]), other).median
        few = errors_of(mapped(other, best[:N_TRANSFER], before=known), other)
        inside.append(np.mean(np.abs(few.in_sigma) < 2.0))
        ratios.append(few.median / own)
        one_more.append(errors_of(mapped(other, best, before=known), other).median / own)
        alone.append(errors_of(mapped(other, poses[:N_TRANSFER]), other).median / own)
    median = float(np.median(ratios))
    return Line(
        f'transfer to an arm of the same make, {N_TRANSFER} poses, {len(ratios)} arms: error over'
        f' that of {N_POSES} poses of its own (peer: {N_TRANSFER} poses without the other map;'
        f' with {N_TRANSFER + 1} poses {np.median(one_more):.2f});'
        f' {100 * np.mean(inside):.1f} % within 2σ',
        f'{median:.2f}', f'{np.median(alone):.2f}', reach='≤ 1.3', met=median <= 1.3,
    )  # fmt: skip
