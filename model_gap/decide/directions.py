"""The directions in which effects and tolerances change some records, and what tells them apart.

References
----------
Hunter and Reiner (1965), doi:10.1080/00401706.1965.10490265.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import ModelError
from modal_core.work.side_by_side import side_by_side
from model_gap.campaign import Rows
from model_gap.effects import Effect
from model_gap.fit import FIT, tolerance_columns
from model_gap.hypothesis import Hypothesis
from model_gap.predict import Predictor

Array = NDArray[np.float64]

# An effect as it may be, and its values; begun from several sides it is still one effect.
Size = tuple[Effect, tuple[float, ...]]
# The sizes every effect is looked at with: the first is the one that is asked about.
Sized = Sequence[tuple[Size, ...]]


@dataclass(frozen=True)
class Told:
    """Log evidence of every effect (n,), and of every one over every other (n, n)."""

    gain: Array
    apart: Array


@dataclass(frozen=True)
class Directions:
    """Products of the directions effects and tolerances have in some records.

    Parameters
    ----------
    places : tuple of slice
        Directions of every effect.
    own : (n, n) array
        Of directions of effects with each other.
    cross : (n, n_tolerances) array
        Of them with tolerances.
    gram : (n_tolerances, n_tolerances) array
        Of tolerances with each other.
    count : int
        Complex data.
    """

    places: tuple[slice, ...]
    own: Array
    cross: Array
    gram: Array
    count: int

    @classmethod
    def of(cls, sized: Sized, present: Hypothesis, predictor: Predictor) -> 'Directions':
        """Predict every effect alone."""
        base = predictor.rows(present.cell())
        columns = tolerance_columns(present, predictor)

        def changed(sizes: tuple[Size, ...]) -> list[Rows]:
            found = []
            for effect, values in sizes:
                try:
                    cell = effect.apply(present.cell(), values, present.scene)
                    change = predictor.rows(cell) - base
                except ModelError:  # not a possible arm at this pose
                    change = np.zeros_like(base)
                found.append(change if np.isfinite(change).all() else np.zeros_like(base))
            return found

        parts = side_by_side(changed, sized)
        rows = np.array([row for part in parts for row in part], dtype=np.float32)
        ends = np.cumsum([len(part) for part in parts]).tolist()
        return cls(
            tuple(slice(end - len(part), end) for end, part in zip(ends, parts, strict=True)),
            np.asarray(rows @ rows.T, dtype=float),
            np.asarray(rows @ columns.T, dtype=float),
            np.asarray(columns @ columns.T, dtype=float),
            predictor.weighting.count,
        )

    def with_more(self, other: 'Directions') -> 'Directions':
        """Return the products over both sets of records."""
        return Directions(
            self.places,
            self.own + other.own,
            self.cross + other.cross,
            self.gram + other.gram,
            self.count + other.count,
        )

    def telling(self) -> Told:
        """Return what the tempered evidence would gain, tolerances free within their priors."""
        weight = 2.0 * FIT.effective_data / self.count
        hessian = weight * self.gram + np.eye(len(self.gram))
        shared = weight**2 * self.cross @ np.linalg.solve(hessian, self.cross.T)
        left = weight * self.own - shared
        first = [place.start for place in self.places]
        own = np.maximum(np.diag(left)[first], 0.0)
        apart = np.empty((len(first), len(first)))
        for column, place in enumerate(self.places):
            basis = left[place, place] + 1e-9 * np.trace(left[place, place]) * np.eye(
                place.stop - place.start
            )
            cross = left[np.ix_(first, range(place.start, place.stop))]
            alike = np.einsum('rb,br->r', cross, np.linalg.pinv(basis) @ cross.T)
            apart[:, column] = np.maximum(own - alike, 0.0)
        return Told(_evidence(own), _evidence(apart))


def _evidence(square: Array) -> Array:
    """Return the rise of log evidence of what leaves so much, twice the log density."""
    data = FIT.effective_data
    return np.asarray(data * np.log1p(square / (2.0 * data)))
