"""Posterior predictive check: how well a fit predicts held-out records within its uncertainty.

At poses that were not fitted a tolerance shows that no fitted pose could tell: an error there is
judged against σ² + J S Jᵀ, S the covariance of all numbers after the fit.

References
----------
Gelman, Meng and Stern (1996), Posterior predictive assessment, Statistica Sinica 6, 733-807.
"""

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import ModelError
from model_gap.fit.fit import Fit
from model_gap.fit.linearise import effect_columns, tolerance_columns
from model_gap.fit.thresholds import FIT
from model_gap.hypothesis import Hypothesis
from model_gap.predict import Predictor


def posterior_predictive_check(fitted: Fit, predictor: Predictor) -> tuple[float, Hypothesis]:
    """Return χ of held-out records, and the hypothesis within the fit's uncertainty it is of.

    The numbers move to where ``effective_data`` log χ + ½ δᵀS⁻¹δ is least, and the way is paid
    for: χ is exp of that minimum over ``effective_data``.

    Parameters
    ----------
    fitted : Fit
        Of other records.
    predictor : Predictor
        Of the held-out records.
    """
    hypothesis = fitted.hypothesis
    rows = predictor.rows(hypothesis.cell())
    plain = predictor.weighting.misfit(rows)
    columns = np.concatenate(
        [
            tolerance_columns(hypothesis, predictor),
            effect_columns(hypothesis, predictor, rows),
        ]
    )
    residual = predictor.weighting.measured - rows
    gram = np.asarray(columns @ columns.T, dtype=float)
    pull = np.asarray(columns @ residual, dtype=float)
    square = plain * predictor.weighting.count
    chi: float = plain
    way: NDArray[np.float64] = np.zeros(len(columns))
    for _ in range(FIT.rounds):
        weight = 2.0 * FIT.effective_data / (predictor.weighting.count * chi)
        way = np.asarray(np.linalg.solve(weight * gram + fitted.precision, weight * pull), float)
        chi = float(square - 2.0 * way @ pull + way @ gram @ way) / predictor.weighting.count
        chi = max(chi, 1e-3 * plain)
    size = len(hypothesis.tolerances)
    moved = hypothesis.moved(
        hypothesis.tolerance_values + way[:size],
        hypothesis.inner + way[size:] * hypothesis.prior_scale,
    )
    try:
        there = predictor.weighting.misfit(predictor.rows(moved.cell()))
    except ModelError:  # not a possible arm
        return plain, hypothesis
    paid = there * float(np.exp(0.5 * way @ fitted.precision @ way / FIT.effective_data))
    return (paid, moved) if paid < plain else (plain, hypothesis)
