"""Evidence bound: what one more effect could gain of what is left and of what tolerances cost."""

import numpy as np

from model_gap.fit import FIT, Fit
from model_gap.search.thresholds import SEARCH


def evidence_bound(fitted: Fit) -> float:
    """Return the log evidence that bringing what is left over down to the noise would gain."""
    return FIT.effective_data * float(np.log(max(fitted.misfit, 1.0)))


def tolerance_excess(fitted: Fit) -> float:
    """Return what tolerances cost beyond what they cost at least where nothing is missing.

    Deviations drawn by chance are found again but for what their prior takes: of the square of
    those found, mean and variance are tr D² and 2 tr D⁴, D one less the covariance.
    """
    values = fitted.hypothesis.tolerance_values
    size = len(values)
    found = np.eye(size) - np.linalg.inv(fitted.precision)[:size, :size]
    square = found @ found
    expected = float(np.trace(square)) - SEARCH.least_chance * float(
        np.sqrt(2.0 * np.sum(square**2))
    )
    return max(0.5 * (float(values @ values) - max(expected, 0.0)), 0.0)


def least_further_gain(before: Fit) -> float:
    """Return what a further effect must gain: a part of what the ones before left over.

    One that takes away a tenth fits what a law of the first describes only roughly.
    """
    if not before.hypothesis.effects:
        return 0.0
    return SEARCH.further_share * evidence_bound(before)
