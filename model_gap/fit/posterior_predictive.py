"""Posterior predictive check: how well a fit predicts held-out records within its uncertainty.

At poses that were not fitted a tolerance shows that no fitted pose could tell: an error there is
judged against σ² + J S Jᵀ, S the covariance of all numbers after the fit.

References
----------
Gelman, Meng and Stern (1996), Posterior predictive assessment, Statistica Sinica 6, 733-807.
"""

import numpy as np
from numpy.typing import NDArray

from model_gap.campaign import Rows
from model_gap.fit.fit import Fit, lower
from model_gap.fit.linearise import effect_columns, tolerance_columns
from model_gap.fit.thresholds import FIT
from model_gap.hypothesis import Hypothesis
from model_gap.predict import Predictor

Array = NDArray[np.float64]


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
    here, way = fitted.hypothesis, np.zeros(len(fitted.precision))
    rows = predictor.rows(here.cell())
    chi = predictor.weighting.misfit(rows)
    paid = chi
    for _ in range(FIT.check_steps):
        step, promised = _step(here, way, rows, chi, fitted, predictor)

        def price(part: Array, _: Hypothesis, misfit: float, way: Array = way) -> float:
            return _paid(misfit, way + part, fitted)

        there = lower(here, step, predictor, paid, price)
        if there is None:
            break
        here, rows, chi, paid = there.hypothesis, there.rows, there.misfit, there.value
        way = way + there.step
        if FIT.effective_data * np.log(paid / promised) < FIT.little_gain:
            break  # as linear as it was taken to be
    return paid, here


def _step(
    here: Hypothesis, way: Array, rows: Rows, chi: float, fitted: Fit, predictor: Predictor
) -> tuple[Array, float]:
    """Return the step to the least χ and price of the way, all linear, and that χ."""
    columns = np.concatenate(
        [tolerance_columns(here, predictor), effect_columns(here, predictor, rows)]
    )
    residual = predictor.weighting.measured - rows
    gram = np.asarray(columns @ columns.T, dtype=float)
    pull = np.asarray(columns @ residual, dtype=float)
    count = predictor.weighting.count
    square, left, step = chi * count, chi, np.zeros(len(way))
    for _ in range(FIT.rounds):
        weight = 2.0 * FIT.effective_data / (count * left)
        force = weight * pull - fitted.precision @ way
        step = np.asarray(np.linalg.solve(weight * gram + fitted.precision, force), float)
        left = max(float(square - 2.0 * step @ pull + step @ gram @ step) / count, 1e-3 * chi)
    return step, _paid(left, way + step, fitted)


def _paid(chi: float, way: Array, fitted: Fit) -> float:
    return chi * float(np.exp(0.5 * way @ fitted.precision @ way / FIT.effective_data))
