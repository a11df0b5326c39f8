"""How large an effect must be to be named: what `none` cannot rule out.

An effect of a small size x changes the spectra by x d.  What tolerances can do as well is
projected out of d, and what is left, squared, gains log evidence with x²: as much as an effect is
worth is asked for, and what its own number costs.  Derivatives they must be: a tolerance follows
what it can stand for as far as it goes, and not along a straight line.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import ModelError
from modal_core.work.side_by_side import side_by_side
from model_gap.campaign import Rows
from model_gap.effects import Effect, EffectParameter
from model_gap.fit import cost, effect_columns, FIT, tolerance_columns
from model_gap.hypothesis import Hypothesis
from model_gap.predict import Predictor
from model_gap.search import is_linear, Search

Array = NDArray[np.float64]
# Of the size and what it costs, which hangs on it by a logarithm: after two it is known to 2 %,
# after four to 0.01 %, for gains of 1e-4 to 1e8 and evidence of 8 or 12.
STEPS = 4
# Of twice the log density: less than that is no change.
NOTHING = 0.1


@dataclass(frozen=True, slots=True)
class LeastSeen:
    """The smallest size at which an effect would be named.

    Parameters
    ----------
    effect : Effect
        At a place, of several axes and ways the one that is seen worst.
    number : EffectParameter
        Its first, which says how large it is.
    value : float
        Of that, all others as they usually are; NaN: it is seen at no plausible size.
    """

    effect: Effect
    number: EffectParameter
    value: float

    @property
    def scales(self) -> float:
        """How many of its prior scales that is from nothing; inf where it is not seen."""
        if np.isnan(self.value):
            return float('inf')
        return abs(self.number.inner(self.value)) / self.number.scale


def least_seen(search: Search) -> tuple[LeastSeen, ...]:
    """Return, of every linear effect of the arm and place, the size from which it would be named.

    Parameters
    ----------
    search : Search
        Its first round is done.
    """
    scene, worth = search.scene, search.settings.worth_adding
    view = _View.of(search.rounds[0].before.hypothesis, search.data.coarse)
    effects = [
        effect
        for kind in search.settings.catalogue
        for effect in kind.instances(scene)
        if is_linear(effect) and effect.parameters(scene)
    ]
    sizes = side_by_side(lambda effect: view.size(effect, worth), effects)
    worst: dict[tuple[str, str], LeastSeen] = {}
    for effect, value in zip(effects, sizes, strict=True):
        if value is None:
            continue
        found = LeastSeen(effect, effect.parameters(scene)[0], value)
        if effect.key not in worst or found.scales > worst[effect.key].scales:
            worst[effect.key] = found
    return tuple(worst.values())


@dataclass(frozen=True)
class _View:
    """What records show beside what tolerances can do.

    Parameters
    ----------
    hypothesis : Hypothesis
        Tolerances alone.
    predictor : Predictor
        Of the records.
    base : (n_rows,) array
        The prediction.
    columns : (n_tolerances, n_rows) array
        Tolerance derivatives.
    hessian : (n_tolerances, n_tolerances) array
        Of the log posterior density.
    """

    hypothesis: Hypothesis
    predictor: Predictor
    base: Rows
    columns: Rows
    hessian: Array

    @classmethod
    def of(cls, hypothesis: Hypothesis, predictor: Predictor) -> '_View':
        columns = tolerance_columns(hypothesis, predictor)
        gram = np.asarray(columns @ columns.T, dtype=float)
        weight = 2.0 * FIT.effective_data / predictor.weighting.count
        hessian = weight * gram + np.eye(len(gram))
        return cls(hypothesis, predictor, predictor.rows(hypothesis.cell()), columns, hessian)

    def size(self, effect: Effect, worth: float) -> float | None:
        """Return the first number from which on an effect gains enough; NaN where none does.

        None of an effect that its first number alone does not make nothing.
        """
        first, *_ = effect.parameters(self.hypothesis.scene)
        starts = effect.starts(self.hypothesis.scene)
        start = tuple(starts[len(starts) // 2])
        nothing, little = (
            self.hypothesis.with_effect(effect, (first.value(inner), *start[1:]))
            for inner in (0.0, FIT.effect_step * first.scale)
        )
        try:
            rows = self.predictor.rows(nothing.cell())
            if self._left(rows - self.base) > NOTHING:
                return None
            if first.low == 0.0:  # out of a rigid arm leads no change of its matrices
                along = (self.predictor.rows(little.cell()) - rows) / FIT.effect_step
            else:
                along, *_ = effect_columns(nothing, self.predictor, rows)
        except ModelError:
            return float('nan')
        sign, gain = float(np.sign(first.inner(start[0]))), self._left(along)
        if not gain > 0.0:
            return float('nan')
        scaled = 1.0
        for _ in range(STEPS):
            asked = worth + 0.5 * float(np.log1p(gain)) + cost(np.array([scaled]))
            scaled = float(np.sqrt(2.0 * asked / gain))
        inner = sign * scaled * first.scale
        inside = first.inner(first.low) <= inner <= first.inner(first.high)
        return first.value(inner) if inside else float('nan')

    def _left(self, change: Rows) -> float:
        """Return twice the log density that a change gains beside all that tolerances can do."""
        weight = 2.0 * FIT.effective_data / self.predictor.weighting.count
        cross = weight * np.asarray(self.columns @ change, dtype=float)
        alone = weight * float(change.astype(float) @ change)
        return alone - float(cross @ np.linalg.solve(self.hessian, cross))
