"""Some of the tolerances fitted, the others as they are."""

from collections.abc import Sequence
from dataclasses import replace

from model_gap.fit.fit import fit
from model_gap.hypothesis import Hypothesis
from model_gap.predict import Predictor


def fit_some(
    hypothesis: Hypothesis, predictor: Predictor, places: Sequence[int], relinearise: int
) -> Hypothesis:
    """Return a hypothesis with some of its tolerances fitted.

    Parameters
    ----------
    hypothesis : Hypothesis
        Start.
    predictor : Predictor
        Of the records.
    places : sequence of int
        Which tolerances; none is a gain.
    relinearise : int
        How often the tolerances are linearised anew at most.
    """
    chosen = list(places)
    free = replace(
        hypothesis,
        tolerances=tuple(hypothesis.tolerances[place] for place in chosen),
        tolerance_values=hypothesis.tolerance_values[chosen],
    )
    values = hypothesis.tolerance_values.copy()
    values[chosen] = fit(free, predictor, relinearise=relinearise).hypothesis.tolerance_values
    return replace(hypothesis, tolerance_values=values)
