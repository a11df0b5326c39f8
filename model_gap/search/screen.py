"""Try every candidate of the catalogue, coarsely: one simulation per starting value.

A candidate's change of the spectra, d, is scaled by a free amplitude and tested against what is
left of the residual when the tolerances may move as well: a score test along the secant, which is
exact for small effects and finds large ones on a grid of starting values.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import ModelError
from modal_core.side_by_side import side_by_side
from model_gap.campaign import Complex, Rows
from model_gap.cell import CellModel
from model_gap.effects import Effect
from model_gap.fit import EFFECTIVE_DATA, free_numbers_cost
from model_gap.hypothesis import Hypothesis
from model_gap.predict import Predictor

Array = NDArray[np.float64]
Start = tuple[float, ...]
LARGEST_AMPLITUDE = 1.3


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

    def value(self, direction: Rows | None) -> tuple[float, float]:
        """Return the best objective with a direction of free amplitude, and that amplitude."""
        size = len(self.columns)
        gram, pull = self.gram, self.pull
        square = float(self.residual.astype(float) @ self.residual)
        if direction is not None:
            cross = np.asarray(self.columns @ direction, dtype=float)
            own = float(direction.astype(float) @ direction)
            gram = np.block([[gram, cross[:, None]], [cross[None, :], np.array([[own]])]])
            pull = np.r_[pull, float(direction.astype(float) @ self.residual)]
        prior = np.r_[np.ones(size), np.zeros(len(gram) - size)]
        centre = np.r_[self.base.tolerance_values, np.zeros(len(gram) - size)]
        chi = square / self.count
        best = (np.inf, 0.0)
        for _ in range(4):
            weight = 2.0 * EFFECTIVE_DATA / (self.count * chi)
            step = _clipped(weight * gram, prior, weight * pull - prior * centre, size)
            left = square - 2.0 * step @ pull + step @ gram @ step
            chi = max(float(left) / self.count, 0.3)
            moved = (centre + step)[:size]
            value = EFFECTIVE_DATA * np.log(chi) + 0.5 * float(moved @ moved)
            if value < best[0]:
                best = (float(value), float(step[size]) if len(step) > size else 0.0)
        return best


def _clipped(gram: Array, prior: Array, pull: Array, size: int) -> Array:
    """Solve for the step; the amplitude, last, is held inside its range."""
    hessian = gram + np.diag(prior)
    hessian[np.diag_indices_from(hessian)] += 1e-12 * np.trace(hessian)
    step = np.linalg.solve(hessian, pull)
    if len(step) == size or 0.0 <= step[size] <= LARGEST_AMPLITUDE:
        return np.asarray(step)
    amplitude = float(np.clip(step[size], 0.0, LARGEST_AMPLITUDE))
    rest = np.linalg.solve(hessian[:size, :size], pull[:size] - hessian[:size, size] * amplitude)
    return np.asarray(np.r_[rest, amplitude])


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
    base, scene = projection.base, projection.base.scene
    present = predictor.hold(base.cell())
    reference, _ = projection.value(None)
    together: dict[str, list[Effect]] = {}  # torques in one joint share its motion
    for number, effect in enumerate(candidates):
        place = effect.place if effect.amplitude_dependent else str(number)
        together.setdefault(place, []).append(effect)

    def work(effects: Sequence[Effect]) -> dict[int, tuple[float, Start]]:
        starts = [
            (n, tuple(it)) for n, effect in enumerate(effects) for it in effect.starts(scene)
        ]
        cells = [effects[n].apply(present, values, scene) for n, values in starts]
        best: dict[int, tuple[float, Start]] = {}
        for (number, values), spectra in zip(starts, _predicted(cells, predictor), strict=True):
            if spectra is None:
                continue
            direction = predictor.weighting.rows(spectra) - projection.rows
            value, amplitude = projection.value(direction)
            if np.isfinite(value) and (number not in best or value < best[number][0]):
                best[number] = value, scaled(effects[number], values, amplitude, base)
        return best

    groups = list(together.values())
    found = []
    for effects, best in zip(groups, side_by_side(work, groups), strict=True):
        for number, (value, values) in best.items():
            effect = effects[number]
            cost = free_numbers_cost([effect], len(predictor.records))
            found.append(Trial(effect, values, reference - value - cost, base))
    return sorted(found, key=lambda trial: -trial.gain)


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
    if not items or 0.6 < amplitude < 1.4:
        return tuple(values)
    first = items[0]
    inner = first.inner(values[0]) * max(amplitude, 0.02)
    return (first.value(inner), *values[1:])
