"""How likely held-out records are, were nothing wrong beyond the tolerances: their joint test.

A mean of squares over thousands of data hides what stands in a few directions; what tolerances
were made up for in the fitted poses shows in others as an error along their derivatives J.  The
residual there is noise, ½ in every real row, and J e, e the error of the fitted tolerances.  With
the data weighted by w and G = JᵀJ of the fitted records, H = w G + I,

e = H⁻¹ (w Jᵀε - θ),  S = H⁻¹ (½ w² G + I) H⁻¹,

for the arm's own tolerances θ are standard normal.  Along the axes of J S Jᵀ the residual has the
variances ½ + s², and the sum of its squares over these is chi-square.

References
----------
Box (1980), Sampling and Bayes' inference in scientific modelling and robustness,
doi:10.2307/2982063: the predictive check of a model on data that took no part.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from model_gap.campaign import Rows
from model_gap.fit.fit import Fit
from model_gap.fit.linearise import tolerance_columns
from model_gap.fit.thresholds import FIT
from model_gap.predict import Predictor

Array = NDArray[np.float64]
# Axes along which an error of all tolerances moves the held-out data by less than so many of
# their deviations together are noise alone: their variance is that of the noise within 2 %.
LEAST_SEEN = 0.1


def heldout_chance(fitted: Fit, fitting: Predictor, heldout: Predictor) -> float:
    """Return the chance that tolerances and noise differ so much from held-out records, or more.

    Parameters
    ----------
    fitted : Fit
        Of tolerances alone.
    fitting, heldout : Predictor
        Of the records it is of, and of those that took no part.
    """
    here = fitted.hypothesis
    at_fitted, columns = (tolerance_columns(here, some) for some in (fitting, heldout))
    gram = np.asarray(at_fitted @ at_fitted.T, dtype=float)
    weight = 2.0 * FIT.effective_data / (fitting.weighting.count * fitted.misfit)
    residual = heldout.weighting.measured - heldout.rows(here.cell())
    return chance(residual, columns, error_of(gram, weight))


def error_of(gram: Array, weight: float) -> Array:
    """Return the covariance of the error of fitted tolerances, in prior standard deviations.

    Parameters
    ----------
    gram : (n_tolerances, n_tolerances) array
        Products of the derivatives by tolerances with each other, of the fitted records.
    weight : float
        Of a squared residual in the fit, against the prior.
    """
    own = np.eye(len(gram))
    pulled = np.linalg.inv(weight * gram + own)
    return np.asarray(pulled @ (0.5 * weight**2 * gram + own) @ pulled)


def chance(residual: Rows, columns: Rows, error: Array) -> float:
    """Return the chance of a residual as far off along the tolerances as this one, or more.

    Parameters
    ----------
    residual : (n_rows,) array
        Noise of variance ½ in every row, and what the error of the tolerances does.
    columns : (n_tolerances, n_rows) array
        Derivatives by tolerances.
    error : (n_tolerances, n_tolerances) array
        Covariance of their error.
    """
    root = np.linalg.cholesky(error)
    spread, axes = np.linalg.eigh(root.T @ np.asarray(columns @ columns.T, dtype=float) @ root)
    seen = spread > LEAST_SEEN**2
    if not seen.any():
        return 1.0
    along = (axes.T @ root.T @ np.asarray(columns @ residual, dtype=float))[seen]
    spread = spread[seen]
    return float(chi2.sf(np.sum(along**2 / (spread * (0.5 + spread))), len(spread)))
