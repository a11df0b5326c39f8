"""Natural frequencies, damping ratios and shapes: measured ones beside the model's."""

from collections.abc import Sequence
import dataclasses
from dataclasses import dataclass
from itertools import chain
import math

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from modal_core.mode import Mode
from modal_core.numbers.indicators import mac
from modal_core.work.side_by_side import side_by_side
from model_gap.campaign import Band, CAMPAIGN, GapRecord
from model_gap.cell import CellModel
from model_gap.fit import Fit, pose_groups
from model_gap.modes.driven_modes import driven_modes
from model_gap.modes.driven_response import driven_response
from model_gap.modes.thresholds import LIMITS
from model_gap.search import Search
from structural_model import FlexibleJointModel

Array = NDArray[np.float64]
MOVING = ('spring', 'spec', 'pose')
"""Kinds of tolerances that move modes; those of sensors do not."""
STEP = 0.1
"""Of a number, in its prior's standard deviation, for its slope: deviations of frequencies are at
most 4 % off in three campaigns."""


@dataclass(frozen=True)
class ModelMode:
    """A mode of the model beside an identified one.

    Parameters
    ----------
    frequency_hz, damping_ratio : float [Hz], [-]
        Of the model.
    frequency_sigma_hz, damping_ratio_sigma : float
        What the model's tolerances make of them, and after a fit what it leaves of these.
    mac : float
        With the identified shape.
    """

    frequency_hz: float
    damping_ratio: float
    frequency_sigma_hz: float
    damping_ratio_sigma: float
    mac: float


@dataclass(frozen=True)
class ModePair:
    """One identified mode of one recording.

    Parameters
    ----------
    record, level : str
        The recording and its amplitude level.
    pose : int
        Number of the pose.
    heldout : bool
        The pose took no part in the fit.
    mode : Mode
        As identified.
    before, after : ModelMode or None
        The model's mode of the same shape, as it was given and as it is now; None: it has none.
    """

    record: str
    level: str
    pose: int
    heldout: bool
    mode: Mode
    before: ModelMode | None
    after: ModelMode | None

    def deviations(self, model: ModelMode | None) -> float:
        """Return the difference in frequency, in standard deviations of both together."""
        if model is None:
            return math.nan
        sigma = math.hypot(_or_zero(self.mode.frequency_std_hz), model.frequency_sigma_hz, 1e-6)
        return (self.mode.frequency_hz - model.frequency_hz) / sigma


@dataclass(frozen=True)
class _Modes:
    poles: NDArray[np.complex128]
    frequency_hz: Array
    damping_ratio: Array
    shapes: NDArray[np.complex128]
    frequency_sigma_hz: Array
    damping_ratio_sigma: Array


def mode_pairs(
    search: Search,
    after: Fit | None,
    highest_hz: float,
    poses: int = LIMITS.most_poses,
    levels: int | None = None,
) -> tuple[ModePair, ...]:
    """Fit modes to some recordings and put the model's modes beside what was found.

    Parameters
    ----------
    search : Search
        Data and the model as it was given.
    after : Fit or None
        The model as it is now; None: as it was given.
    highest_hz : float [Hz]
        Up to where the arm was excited.
    poses : int
        In at most so many.
    levels : int or None
        The first so many recordings of each pose; None: all.
    """
    campaign = search.campaign
    groups = pose_groups(campaign)
    band = Band(LIMITS.lowest_hz, min(highest_hz, LIMITS.highest_hz))
    if band.high_hz < CAMPAIGN.least_width * band.low_hz:
        return ()
    given = _given(search)
    now = given if after is None else _fitted(search, after)
    asked: list[tuple[int, GapRecord, tuple[_Modes, _Modes]]] = []
    for pose, records in _chosen(campaign.records, groups)[:poses]:
        q = records[0].pose
        sides = (_model_modes(search, given, q), _model_modes(search, now, q))
        asked += [(pose, record, sides) for record in records[:levels]]

    def measured(each: tuple[int, GapRecord, tuple[_Modes, _Modes]]) -> list[ModePair]:
        pose, record, sides = each
        response = driven_response(record, band, now.cell, search.scene.lines_hz)
        modes = driven_modes(response, [side.poles for side in sides])
        pairs = (_matched(modes, side, response.channels) for side in sides)
        return [
            ModePair(record.name, record.level, pose, bool(record.heldout), *pair)
            for pair in zip(modes, *pairs, strict=True)
        ]

    return tuple(chain.from_iterable(side_by_side(measured, asked)))


def _chosen(
    records: Sequence[GapRecord], groups: Sequence[int]
) -> list[tuple[int, list[GapRecord]]]:
    """Return the poses with all their levels, held-out ones first."""
    poses: dict[int, list[GapRecord]] = {}
    for record, group in zip(records, groups, strict=True):
        poses.setdefault(group, []).append(record)
    return sorted(poses.items(), key=lambda item: not item[1][0].heldout)


@dataclass(frozen=True)
class _Uncertain:
    """A model, arms a step of its numbers away as far as they move modes, and the covariance."""

    cell: CellModel
    steps: Sequence[FlexibleJointModel]
    covariance: Array


def _given(search: Search) -> _Uncertain:
    cell = search.nominal.cell()
    moving = [item for item in search.tolerances if item.kind in MOVING]
    steps = [_arm(search, item.apply(cell, 1.0)) for item in moving]
    return _Uncertain(cell, steps, np.eye(len(moving)))


def _fitted(search: Search, fit: Fit) -> _Uncertain:
    hypothesis, size = fit.hypothesis, len(fit.precision)
    kinds = [item.kind for item in hypothesis.tolerances]
    moving = [n for n in range(size) if n >= len(kinds) or kinds[n] in MOVING]
    covariance = np.asarray(np.linalg.inv(fit.precision)[np.ix_(moving, moving)] / STEP**2)
    cells = (hypothesis.stepped(STEP * np.eye(size)[n]).cell() for n in moving)
    steps = [_arm(search, cell) for cell in cells]
    return _Uncertain(hypothesis.cell(), steps, covariance)


def _model_modes(search: Search, uncertain: _Uncertain, q: Array) -> _Modes:
    cell = uncertain.cell
    modes = search.model.replace(cell.spec).damped_modes(q, cell.channels)
    omega = 2.0 * np.pi * modes.frequency_hz
    shapes = cell.seen(omega, np.asarray(modes.channel_shapes))
    changes = np.zeros((len(uncertain.steps), 2, len(omega)))
    for row, step in zip(changes, uncertain.steps, strict=True):
        row[:] = _change(step, q, modes.frequency_hz, modes.damping_ratio)
    variance = np.einsum('ikm,ij,jkm->km', changes, uncertain.covariance, changes)
    sigma = np.sqrt(np.maximum(variance, 0.0))
    return _Modes(
        modes.poles_1_s, modes.frequency_hz, modes.damping_ratio, shapes, sigma[0], sigma[1]
    )


def _arm(search: Search, cell: CellModel) -> FlexibleJointModel:
    return dataclasses.replace(search.model, spec=cell.spec)


def _change(arm: FlexibleJointModel, q: Array, frequency_hz: Array, damping_ratio: Array) -> Array:
    """Return how frequencies and damping ratios change; where springs give way that did not, too.

    Such a step has more modes: each mode's own is the nearest of them.
    """
    modes = arm.damped_modes(q, ())
    change = np.zeros((2, len(frequency_hz)))
    own = np.arange(len(frequency_hz))
    there = own
    if len(modes.frequency_hz) != len(frequency_hz):
        off = np.abs(np.log(modes.frequency_hz / frequency_hz[:, None]))
        own, there = linear_sum_assignment(off)
    change[0, own] = modes.frequency_hz[there] - frequency_hz[own]
    change[1, own] = modes.damping_ratio[there] - damping_ratio[own]
    return change


def _matched(
    found: Sequence[Mode], model: _Modes, seen: NDArray[np.intp]
) -> list[ModelMode | None]:
    """Give every identified mode at most one of the model's: like shape, like frequency."""
    pairs: list[ModelMode | None] = [None] * len(found)
    if not pairs:
        return pairs
    likeness = mac(np.stack([mode.shape for mode in found], axis=1), model.shapes[seen])
    frequency = np.array([mode.frequency_hz for mode in found])
    off = np.abs(np.log(frequency[:, None] / model.frequency_hz))
    rows, columns = linear_sum_assignment(1.0 - likeness + LIMITS.frequency_weight * off)
    for row, column in zip(rows.tolist(), columns.tolist(), strict=True):
        if likeness[row, column] >= LIMITS.least_mac and off[row, column] <= LIMITS.most_off:
            pairs[row] = ModelMode(
                frequency_hz=float(model.frequency_hz[column]),
                damping_ratio=float(model.damping_ratio[column]),
                frequency_sigma_hz=float(model.frequency_sigma_hz[column]),
                damping_ratio_sigma=float(model.damping_ratio_sigma[column]),
                mac=float(likeness[row, column]),
            )
    return pairs


def _or_zero(value: float) -> float:
    return value if math.isfinite(value) else 0.0
