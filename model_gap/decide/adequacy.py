"""What an explanation leaves over by band and level: a wrong one leaves it somewhere.

A mean over everything hides a residual that stands in one band at one amplitude level; there it
is what a wrong law leaves: a stop, a slipping spring or a clipped sensor taken for something else.
"""

from dataclasses import dataclass, replace
import itertools

import numpy as np
from numpy.typing import NDArray

from model_gap.campaign import CAMPAIGN
from model_gap.fit import Fit, heldout_chance, posterior_predictive_check
from model_gap.hypothesis import Hypothesis
from model_gap.predict import Predictor
from model_gap.search import Search

Array = NDArray[np.float64]
# Fewer complex data say too little of a mean of squares.
LEAST_DATA = 100


@dataclass(frozen=True)
class BandLevel:
    """χ of one band at one amplitude level.

    Parameters
    ----------
    place : str
        For people.
    misfit : float
        Mean of |Y - Ŷ|²/σ².
    count : int
        Complex data.
    """

    place: str
    misfit: float
    count: int = 1


NOWHERE = BandLevel('', float('nan'))


@dataclass(frozen=True)
class Adequacy:
    """How well a hypothesis fits, as numbers whose spread on healthy arms is known.

    Parameters
    ----------
    fitted, heldout : float
        χ; of held-out records with what the fit leaves uncertain allowed for, NaN without any.
    count, count_heldout : int
        Complex data of both.
    chance : float
        That held-out records differ so much or more, were there tolerances and noise alone; 1 of
        a fit with effects and without such records.
    worst, worst_heldout : BandLevel
        Where χ is largest.
    stretched : float
        Largest tolerance, in prior standard deviations.
    stretched_name : str
        Which.
    """

    fitted: float
    heldout: float
    worst: BandLevel
    worst_heldout: BandLevel
    stretched: float
    stretched_name: str
    count: int = 1
    count_heldout: int = 1
    chance: float = 1.0

    @property
    def of_fitted(self) -> 'Adequacy':
        """The same, judged by fitted records alone."""
        return replace(self, heldout=float('nan'), worst_heldout=NOWHERE, chance=1.0)


def adequacy(search: Search, fit: Fit) -> Adequacy:
    """Measure what a fit leaves over on fitting and held-out records."""
    hypothesis = fit.hypothesis
    misfit, worst = _misfits(search.data.fitting, hypothesis)
    heldout, worst_heldout, chance = float('nan'), NOWHERE, 1.0
    if search.data.heldout.records:
        heldout, moved = posterior_predictive_check(fit, search.data.heldout)
        _, worst_heldout = _misfits(search.data.heldout, moved)
        if not hypothesis.effects:
            chance = heldout_chance(fit, search.data.fitting, search.data.heldout)
    count, count_heldout = (
        max(sum(item.count for item in some.records), 1)
        for some in (search.data.fitting, search.data.heldout)
    )
    values = np.abs(hypothesis.tolerance_values)
    most = int(np.argmax(values)) if len(values) else -1
    return Adequacy(
        misfit,
        heldout,
        worst,
        worst_heldout,
        float(values[most]) if len(values) else 0.0,
        hypothesis.tolerances[most].name if len(values) else '',
        count,
        count_heldout,
        chance,
    )


def _misfits(predictor: Predictor, hypothesis: Hypothesis) -> tuple[float, BandLevel]:
    sums: dict[tuple[str, str], Array] = {}
    parts = predictor.squares(hypothesis.cell())
    for item, squares in zip(predictor.records, parts, strict=True):
        for low, high in itertools.pairwise(CAMPAIGN.band_edges_hz):
            inside = (item.frequency_hz >= low) & (item.frequency_hz < high)
            part = squares[item.record.recorded][:, inside]
            place = (f'{low:g}-{high:g} Hz', item.record.level)
            sums[place] = sums.get(place, np.zeros(2)) + np.array([part.sum(), part.size])
    total, count = np.sum(list(sums.values()), axis=0)
    places = [
        BandLevel(f'{band} at level {level}', float(square / size), int(size))
        for (band, level), (square, size) in sums.items()
        if size >= LEAST_DATA
    ]
    whole = BandLevel('', float(total / count), int(count))
    return whole.misfit, max(places, key=lambda place: place.misfit, default=whole)
