"""From measured poses to what the arm has and its model lacks, at any pose.

Gauss-Newton on the most probable functions: linearise every pose about its present state, regress
on all rows at once, take the new functions' values at the poses, until nothing moves.  Again from
other beginnings, until two fits are as probable.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from workspace_map.arm import Arm, ArmAtPose, frequency_slopes, local_modes, LocalModes, State
from workspace_map.measured_pose import MeasuredPose
from workspace_map.pairing import alike, pair
from workspace_map.prior import (
    damping_scales,
    FREQUENCY,
    of_same_make,
    SPREAD,
    state_of,
    structure_of,
    structure_parts,
    structure_scales,
    TOOLS_OWN,
)
from workspace_map.regression import (
    deviation_factor,
    evidence_of,
    most_probable_scales,
    Posterior,
    posterior,
    Rows,
    Scales,
    Shared,
)
from workspace_map.rows import Block, damping_block, Pairs, stacked, structure_block

Array = NDArray[np.float64]
Before = Callable[[Array], State]
MOST_STEPS, SCALES_AT = 30, {3: 0, 6: 2, 10: 0}
"""Steps of a fit; before which of them scales are sought anew, with how many further starts."""
SMALL_STEP, LARGEST_STEP = 1e-3, 0.7
"""Of a state: where a fit has come to rest, and how far it goes at once."""
SLOW, LEAST_PART = 0.8, 0.1
"""A step that is more than this part of the last one is halved, down to this part."""
FAR = 0.1
"""What a step of one in the farthest spring does to log f: half, times a share of the energy."""
BEYOND_BAND = 1.5
"""Modes that the model has above the band may be below it in truth."""
DRAWS, WIDTHS, SHARES, LOOKED_AT, ROUGH_STD = 500, (0.3, 1.0, 3.0), (0.03, 0.2, 1.0), 5, 0.05
"""Beginnings that are tried, how far apart, in which share of the members of a part, at how many
poses, and what is near in log f."""
WORTH = 5.0
"""What a mode that is explained adds to the log likelihood; what an arm has for it takes away."""
MOST_BEGINNINGS, AS_PROBABLE = 5, 10.0
"""Fits that are tried at most, and nats within which two are taken for the same place.  Of 63 arms
2 came to rest 330 and 770 nats below the best place from one beginning, and were wrong by 17 and
29 % in one mode of twenty."""
FEWEST_POSES = 2
"""From which on scales are sought: one pose cannot tell what varies from what does not."""


@dataclass(frozen=True)
class Fitted:
    """What the measured poses say.

    Parameters
    ----------
    structure, dampers : Posterior
        Of springs, couplings and masses; of dampers.
    centres : Centres
        What the rows were linearised about.
    factors : (2,) tuple of float
        On the standard deviations of structure and dampers, from poses left out in turn.
    misfit : float
        Mean square of what is left over of the frequencies and shapes, over its expectation.
    """

    structure: Posterior
    dampers: Posterior
    centres: 'Centres'
    factors: tuple[float, float] = (1.0, 1.0)
    misfit: float = 0.0


@dataclass(frozen=True)
class Centres:
    """What rows are linearised about; with the scales it gives the same fit again.

    Parameters
    ----------
    states : tuple of State
        At the measured poses.
    pairs : tuple of Pairs
        Measured modes and which of the expected they are, per pose.
    """

    states: tuple[State, ...] = ()
    pairs: tuple[Pairs, ...] = ()


def fit(
    arm: Arm,
    measured: Sequence[MeasuredPose],
    highest_hz: float,
    before: Before,
    scales: tuple[Scales, Scales] | None = None,
    prior: tuple[Scales, Scales] | None = None,
    centres: Centres | None = None,
    other: 'Fitted | None' = None,
    same_tool: bool = True,
) -> Fitted:
    """Return the most probable functions, given measured poses.

    Parameters
    ----------
    arm : Arm
        The robot, its sensors and tool.
    measured : sequence of MeasuredPose
        What was found.
    highest_hz : float [Hz]
        Modes below it count.
    before : callable
        What is known beforehand of the arm at a pose: a `State`.
    scales : tuple of Scales, optional
        Of structure and dampers, of an earlier fit: kept.
    prior : tuple of Scales, optional
        Medians; by default those of arms in general.
    centres : Centres, optional
        Of an earlier fit to the same poses: not sought anew.
    other : Fitted, optional
        Of the arm that is known beforehand: what is not known of it is not known of this one.
    same_tool : bool
        Whether that arm has this one's tool, so that its payload tells of this one's.
    """
    q = np.array([each.q for each in measured]).reshape(-1, arm.model.n_joints)
    places = [arm.at(row) for row in q]
    known = [before(row) for row in q]
    general = structure_scales(q.shape[1]), damping_scales(q.shape[1])
    medians = prior or (general if other is None else of_same_make(*general))
    beyond_hz = BEYOND_BAND * highest_hz
    problem = _Problem(
        arm, tuple(measured), tuple(places), q, tuple(known), beyond_hz, _told(other, same_tool)
    )
    if scales is not None and centres is not None:
        system = _System.about(problem, centres.states, centres.pairs)
        return system.calibrated(system.solved(scales))
    return _most_probable(problem, medians, scales)


@dataclass(frozen=True)
class _Problem:
    """What stays the same during a fit."""

    arm: Arm
    measured: tuple[MeasuredPose, ...]
    places: tuple[ArmAtPose, ...]
    q: Array
    known: tuple[State, ...]
    highest_hz: float
    before: 'Told'
    """Of the other arm: its structure and dampers."""

    def modes(self, states: Sequence[State]) -> list[LocalModes]:
        each = zip(self.places, self.known, states, strict=True)
        return [local_modes(place, a.plus(b), self.highest_hz) for place, a, b in each]

    def aimed(self, found: Fitted) -> list[State]:
        return [
            state_of(self.arm, found.structure.functions(row), found.dampers.functions(row))
            for row in self.q
        ]


def _told(other: Fitted | None, same_tool: bool) -> 'Told':
    """Return what is known of structure and dampers by another arm."""
    if other is None:
        return None, None
    structure = other.structure if same_tool else Shared(other.structure, TOOLS_OWN)
    return structure, other.dampers


def log_evidence(found: Fitted, measured: Sequence[MeasuredPose]) -> float:
    """Return how probable measured modes are by a fit's prior; modes not explained count."""
    structure = found.structure
    misfit = np.sum((structure.factor.T @ structure.weight) ** 2)
    explained = sum(len(pairs[0]) for pairs in found.centres.pairs)
    unexplained = sum(len(pose) for pose in measured) - explained
    size = np.sum(np.log(np.diag(structure.factor)))
    return float(-0.5 * misfit - size - WORTH * unexplained)


def _most_probable(
    problem: _Problem, prior: tuple[Scales, Scales], kept: tuple[Scales, Scales] | None
) -> Fitted:
    """Return the most probable of fits from several beginnings, until two are as probable.

    Each may come to rest in a wrong place: with springs that no arm has, and modes that nobody
    measured.
    """
    scales = kept or prior
    if not problem.measured:
        return _nothing(problem, scales)
    found: list[tuple[float, Fitted]] = []
    for begin in _beginnings(problem, scales[0]):
        one = _descend(problem, prior, kept, begin)
        found.append((log_evidence(one, problem.measured), one))
        found.sort(key=lambda each: -each[0])
        if len(found) > 1 and found[0][0] - found[1][0] < AS_PROBABLE:
            break
    return found[0][1]


def _beginnings(problem: _Problem, scales: Scales) -> Iterator[State]:
    yield State.none(problem.arm.n_dof, problem.arm.n_masses)
    for seed in range(MOST_BEGINNINGS - 1):
        yield most_alike(problem, scales, seed)


def _descend(
    problem: _Problem,
    prior: tuple[Scales, Scales],
    kept: tuple[Scales, Scales] | None,
    begin: State,
) -> Fitted:
    scales = kept or prior
    found = _nothing(problem, scales)
    states = [begin] * len(problem.measured)
    part, moved = 1.0, np.inf
    for step in range(MOST_STEPS):
        system = _System.about(problem, states, _paired(problem, states, found, moved))
        if kept is None and step in SCALES_AT and len(states) >= FEWEST_POSES:
            scales = (
                system.scales(0, prior[0], scales[0], SCALES_AT[step]),
                system.scales(1, prior[1], scales[1], SCALES_AT[step]),
            )
        found = system.solved(scales)
        before, aimed = moved, problem.aimed(found)
        moved = _farthest(states, aimed)
        # Where poses pull to and fro the way is shortened until they agree.
        part = max(LEAST_PART, 0.5 * part) if moved > SLOW * before else min(1.0, 1.5 * part)
        reach = min(part, LARGEST_STEP / max(moved, SMALL_STEP))
        states = [a.towards(b, reach) for a, b in zip(states, aimed, strict=True)]
        if moved < SMALL_STEP and (kept is not None or step > max(SCALES_AT)):
            break
    return system.calibrated(found)


Told = tuple[Posterior | Shared | None, Posterior | None]
Linear = tuple[Rows, Array, Array]


@dataclass(frozen=True)
class _System:
    """All poses linearised: rows, residuals from no departure, and their deviations."""

    structure: Linear
    dampers: Linear
    centres: Centres
    before: 'Told'

    @classmethod
    def about(
        cls, problem: _Problem, states: Sequence[State], pairs: Sequence[Pairs]
    ) -> '_System':
        arm = problem.arm
        structure, dampers = [], []
        each = zip(problem.modes(states), problem.measured, states, pairs, strict=True)
        for modes, measured, state, same in each:
            block = structure_block(arm, modes, measured, same)
            structure.append(_from_nothing(block, structure_of(arm, state)))
            block = damping_block(arm, modes, measured, same)
            own = state.damper[~arm.is_base], state.damper[arm.is_base]
            dampers.append(_from_nothing(block, own))
        linear = stacked(structure, problem.q), stacked(dampers, problem.q)
        return cls(*linear, Centres(tuple(states), tuple(pairs)), problem.before)

    def solved(self, scales: tuple[Scales, Scales]) -> Fitted:
        structure, dampers = (
            posterior(*linear, scale, before)
            for linear, scale, before in zip(
                (self.structure, self.dampers), scales, self.before, strict=True
            )
        )
        residual = self.structure[1]
        misfit = float(residual @ structure.weight) / max(len(residual), 1)
        return Fitted(structure, dampers, self.centres, misfit=misfit)

    def scales(self, part: int, prior: Scales, start: Scales, restarts: int) -> Scales:
        """Return the most probable scales of structure (0) or dampers (1)."""
        linear, before = (self.structure, self.dampers)[part], self.before[part]
        known = None if before is None else before.covariance(linear[0], linear[0])
        evidence = evidence_of(*linear, prior, SPREAD, known)
        return most_probable_scales(evidence, start, restarts)

    def calibrated(self, found: Fitted) -> Fitted:
        structure, dampers = (
            deviation_factor(each, *linear[1:], FREQUENCY)
            for each, linear in (
                (found.structure, self.structure),
                (found.dampers, self.dampers),
            )
        )
        return replace(found, factors=(structure, dampers))


def _paired(
    problem: _Problem, states: Sequence[State], found: Fitted, moved: float
) -> list[Pairs]:
    """Return which measured mode is which; less strictly while the states still move."""
    rough = min(FAR * moved, ROUGH_STD)
    return [
        pair(measured, modes, np.hypot(frequency_std(problem.arm, modes, found.structure), rough))
        for measured, modes in zip(problem.measured, problem.modes(states), strict=True)
    ]


def most_alike(problem: _Problem, scales: Scales, seed: int) -> State:
    """Return a state, the same at all poses, whose modes look much like the measured ones.

    A search by chance, from no departure on, in one part of what an arm may have at a time: modes
    far from the model's are then paired with the right ones. A pairing wrong at first stays so.
    """
    arm, generator = problem.arm, np.random.default_rng(seed)
    none = State.none(arm.n_dof, arm.n_masses)
    dampers = none.damper[~arm.is_base], none.damper[arm.is_base]
    chosen = range(0, len(problem.measured), max(1, len(problem.measured) // LOOKED_AT))
    best, most = structure_of(arm, none), -np.inf
    for number in range(DRAWS):
        drawn = list(best)
        part = number % len(drawn)
        count = len(drawn[part])
        size = scales.constant[part] * generator.choice(WIDTHS)
        some = generator.random(count) < generator.choice(SHARES)
        if number:
            drawn[part] = drawn[part] + size * some * generator.standard_normal(count)
        state = state_of(arm, tuple(drawn), dampers)
        like = WORTH * sum(_likeness(problem, each, state) for each in chosen)
        for members, scale in zip(drawn, scales.constant, strict=True):
            like -= 0.5 * np.sum((members / (WIDTHS[-1] * scale)) ** 2)
        if like > most:
            best, most = tuple(drawn), like
    return state_of(arm, best, dampers)


def _likeness(problem: _Problem, number: int, state: State) -> float:
    whole = problem.known[number].plus(state)
    modes = local_modes(problem.places[number], whole, problem.highest_hz)
    return alike(problem.measured[number], modes, np.full(modes.n, ROUGH_STD))


def frequency_std(arm: Arm, modes: LocalModes, found: Posterior) -> Array:
    """Return how sure the frequencies of modes at a pose are, relative, (n_modes,)."""
    rows = rows_at(structure_parts(arm, frequency_slopes(modes)), modes.arm.q)
    own = np.diag(found.covariance(rows, rows)) + found.scales.white[FREQUENCY] ** 2
    return np.asarray(np.sqrt(np.maximum(own, 0.0)))


def rows_at(parts: tuple[Array, ...], q: Array, kind: int = FREQUENCY) -> Rows:
    """Return rows of one kind at one pose."""
    count = len(parts[0])
    return Rows(parts, q[None], np.zeros(count, dtype=np.intp), np.full(count, kind))


def _nothing(problem: _Problem, scales: tuple[Scales, Scales]) -> Fitted:
    """Return what is known before anything is measured."""
    arm = problem.arm
    none = State.none(arm.n_dof, arm.n_masses)
    members = structure_of(arm, none), (none.damper[~arm.is_base], none.damper[arm.is_base])
    empty = (
        Rows(
            tuple(np.zeros((0, len(part))) for part in parts),
            np.zeros((0, arm.model.n_joints)),
            np.zeros(0, dtype=np.intp),
            np.zeros(0, dtype=np.intp),
        )
        for parts in members
    )
    nothing = np.zeros(0)
    structure, dampers = (
        posterior(rows, nothing, nothing, scale, before)
        for rows, scale, before in zip(empty, scales, problem.before, strict=True)
    )
    return Fitted(structure, dampers, Centres())


def _from_nothing(block: Block, members: tuple[Array, ...]) -> Block:
    """Return a block about a state as one about no departure: rows times the state added."""
    there = sum(part @ own for part, own in zip(block.parts, members, strict=True))
    return replace(block, residual=block.residual + there)


def _farthest(states: Sequence[State], aimed: Sequence[State]) -> float:
    """Return how far the farthest spring is from its aim."""
    each = zip(states, aimed, strict=True)
    return float(max(np.max(np.abs(b.spring - a.spring)) for a, b in each))
