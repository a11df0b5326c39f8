"""Try every candidate of the catalogue, coarsely: one simulation per starting value.

A candidate's change of the spectra, d, is scaled by a free amplitude and tested against what is
left of the residual when the tolerances may move as well: a score test along the secant, which is
exact for small effects and finds large ones on a grid of starting values.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
import logging

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import ModelError
from modal_core.work.side_by_side import side_by_side
from model_gap.campaign import Complex, Rows
from model_gap.cell import CellModel
from model_gap.effects import Effect, Scene
from model_gap.fit import FIT, free_numbers_cost
from model_gap.hypothesis import Hypothesis
from model_gap.predict import Predictor
from model_gap.search.thresholds import SEARCH

Array = NDArray[np.float64]
Start = tuple[float, ...]
# Objective, start, and how far the strongest start moves the prediction [sigma, rms].
Tried = tuple[float, Start, float]
log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Trial:
    """One candidate at its best starting value.

    Parameters
    ----------
    effect : Effect
        Candidate.
    values : tuple of float
        Start for a fit.
    gain : float
        Promised rise of the log posterior density.
    base : Hypothesis
        What it was added to.
    """

    effect: Effect
    values: tuple[float, ...]
    gain: float
    base: Hypothesis


@dataclass(frozen=True)
class Projection:
    """The residual of a base hypothesis and the directions tolerances can take it.

    Parameters
    ----------
    base : Hypothesis
        Whose residual it is.
    rows, residual : (n_rows,) array
        Prediction, and measured less prediction.
    columns : (n_tolerances, n_rows) array
        Tolerance derivatives.
    gram, pull : array
        Their products with themselves and with the residual.
    count : int
        Complex data.
    """

    base: Hypothesis
    rows: Rows
    residual: Rows
    columns: Rows
    gram: Array
    pull: Array
    count: int

    @classmethod
    def of(cls, base: Hypothesis, predictor: Predictor, columns: Rows) -> 'Projection':
        """Project about a base hypothesis."""
        rows = predictor.rows(base.cell())
        residual = predictor.weighting.measured - rows
        return cls(
            base,
            rows,
            residual,
            columns,
            np.asarray(columns @ columns.T, dtype=float),
            np.asarray(columns @ residual, dtype=float),
            predictor.weighting.count,
        )

    @cached_property
    def axes(self) -> tuple[Array, Array]:
        """Eigenvalues of the gram matrix, and its eigenvectors as columns."""
        values, vectors = np.linalg.eigh(self.gram)
        return values, vectors

    def value(self, direction: Rows | None) -> tuple[float, float]:
        """Return the best objective with a direction of free amplitude, and that amplitude."""
        values, vectors = self.axes
        pull, centre = vectors.T @ self.pull, vectors.T @ self.base.tolerance_values
        cross, own, along = np.zeros(len(values)), 0.0, 0.0
        if direction is not None:
            cross = vectors.T @ np.asarray(self.columns @ direction, dtype=float)
            wide = direction.astype(float)
            own, along = float(wide @ direction), float(wide @ self.residual)
        square = self.square
        chi = square / self.count
        best = (np.inf, 0.0)
        for _ in range(4):
            weight = 2.0 * FIT.effective_data / (self.count * chi)
            step, amplitude = _clipped(weight, values, pull, centre, cross, (own, along))
            left = square - 2.0 * (step @ pull + amplitude * along)
            left += step @ (values * step) + amplitude * (2.0 * (step @ cross) + amplitude * own)
            chi = max(float(left) / self.count, 0.3)
            moved = centre + step
            value = FIT.effective_data * np.log(chi) + 0.5 * float(moved @ moved)
            if value < best[0]:
                best = float(value), amplitude
        return best

    @cached_property
    def square(self) -> float:
        """Sum of the squared residual."""
        return float(self.residual.astype(float) @ self.residual)


def _clipped(
    weight: float,
    values: Array,
    pull: Array,
    centre: Array,
    cross: Array,
    direction: tuple[float, float],
) -> tuple[Array, float]:
    """Solve for the step along the axes of the tolerances, and for the amplitude in its range.

    Parameters
    ----------
    weight : float
        Of the data against the prior.
    values, pull, centre, cross : (n_tolerances,) array
        Eigenvalues of the gram matrix; along its axes, products of the derivatives with the
        residual, where the tolerances are, and products with the direction.
    direction : (float, float)
        Its products with itself and with the residual; both 0 without any.
    """
    own, along = direction
    size = len(values)
    ridge = 1e-12 * (weight * (float(values.sum()) + own) + size)
    soft = 1.0 / (weight * values + 1.0 + ridge)
    rest = soft * (weight * pull - centre)
    if not own:
        return rest, 0.0
    follows = soft * weight * cross
    stiff = weight * own + ridge - weight * float(cross @ follows)
    amplitude = weight * (along - float(cross @ rest)) / stiff
    amplitude = float(np.clip(amplitude, 0.0, SEARCH.largest_amplitude))
    return rest - amplitude * follows, amplitude


def screen(
    candidates: Sequence[Effect], projection: Projection, predictor: Predictor
) -> list[Trial]:
    """Return every candidate at its best start, the most promising first.

    Parameters
    ----------
    candidates : sequence of Effect
        To try.
    projection : Projection
        Of the hypothesis to add them to.
    predictor : Predictor
        Of the records to screen on.
    """
    base = projection.base
    present = predictor.hold(base.cell())
    reference, _ = projection.value(None)
    together: dict[str, list[Effect]] = {}  # torques in one joint share its motion
    for number, effect in enumerate(candidates):
        place = effect.place if effect.amplitude_dependent else str(number)
        together.setdefault(place, []).append(effect)

    def work(effects: Sequence[Effect]) -> dict[int, Tried]:
        return _tried(effects, present, projection, predictor)

    groups = list(together.values())
    found = []
    for effects, best in zip(groups, side_by_side(work, groups), strict=True):
        for number, (value, values, moved) in best.items():
            effect = effects[number]
            if moved < SEARCH.least_seen:
                log.debug('%r cannot be seen here: at most %.2g of the noise', effect, moved)
                continue
            cost = free_numbers_cost([effect], len(predictor.records))
            found.append(Trial(effect, values, reference - value - cost, base))
    return sorted(found, key=lambda trial: -trial.gain)


def _tried(
    effects: Sequence[Effect], present: CellModel, projection: Projection, predictor: Predictor
) -> dict[int, Tried]:
    """Return the best start of every effect, by its number; those that do too little are grown."""
    base, scene = projection.base, projection.base.scene
    best: dict[int, Tried] = {}
    starts = [(n, tuple(it)) for n, effect in enumerate(effects) for it in effect.starts(scene)]
    for _ in range(SEARCH.most_grown):
        weak = []
        cells = [effects[n].apply(present, values, scene) for n, values in starts]
        for (number, values), spectra in zip(starts, _predicted(cells, predictor), strict=True):
            if spectra is None:
                continue
            direction = predictor.weighting.rows(spectra) - projection.rows
            # What makes an arm unstable grows beyond all numbers, and is no start.
            with np.errstate(over='ignore', invalid='ignore'):
                moved = float(np.sqrt(direction @ direction / projection.count))
                value, amplitude = projection.value(direction)
            least, at, most = best.get(number, (np.inf, values, 0.0))
            if np.isfinite(value) and value < least:
                least, at = value, scaled(effects[number], values, amplitude, base)
            if np.isfinite(least):
                best[number] = least, at, max(most, moved)
            if moved < SEARCH.least_moved:
                weak.append((number, values))
        grown = [(n, values, larger(effects[n], values, scene)) for n, values in weak]
        starts = list(dict.fromkeys((n, new) for n, old, new in grown if new != old))
        if not starts:
            break
    return best


def larger(effect: Effect, values: Start, scene: Scene) -> Start:
    """Return a start with its size farther from neutral, as far as that is plausible.

    The size is its first number and what has the same unit; one that is a factor is as it is: its
    starts span what is plausible.
    """
    items = effect.parameters(scene)
    if not items or items[0].log:
        return values
    return tuple(
        item.value(SEARCH.growth * item.inner(value)) if item.is_size_of(items[0]) else value
        for item, value in zip(items, values, strict=True)
    )


def _predicted(cells: Sequence[CellModel], predictor: Predictor) -> list[list[Complex] | None]:
    """Return the prediction of every cell, None for an impossible arm."""
    if any(cell.forces for cell in cells):
        try:
            return list(predictor.predict_many(cells))
        except ModelError:
            return [None] * len(cells)  # they share their arm
    found: list[list[Complex] | None] = []
    for cell in cells:
        try:
            found.append(predictor.predict(cell))
        except ModelError:
            found.append(None)
    return found


def scaled(
    effect: Effect, values: Sequence[float], amplitude: float, base: Hypothesis
) -> tuple[float, ...]:
    """Return starting values with the first one's distance from neutral scaled."""
    items = effect.parameters(base.scene)
    factor = growth_of(amplitude)
    if not items or factor == 1.0:
        return tuple(values)
    first = items[0]
    return (first.value(first.inner(values[0]) * factor), *values[1:])


def growth_of(amplitude: float) -> float:
    """Return by what a start is made larger or smaller where it fits best with an amplitude."""
    return 1.0 if 0.6 < amplitude < 1.4 else max(amplitude, 0.02)
