"""The Whittle likelihood of a band, maximised by Fisher scoring."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dpotrf, dpotri

from oma_identifier.likelihood.band_model import (
    BandData,
    BandFit,
    BandModel,
    without_negative,
)
from oma_identifier.likelihood.force_prior import Prior
from oma_identifier.likelihood.known_mean import Mean
from oma_identifier.likelihood.scoring_step import (
    moved,
    n_force_parameters,
    quadratic_at,
    scoring_step,
)
from oma_identifier.likelihood.thresholds import LIKELIHOOD
from oma_identifier.likelihood.whittle import across, evaluate, Evaluation

NEARLY_UNDAMPED = 0.1
FIRST_DAMPING, LEAST_DAMPING, LARGEST_DAMPING = 1e-3, 1e-12, 1e6
NEARLY_SINGULAR = 1e-9
"""Share of a parameter's information that the others leave, from where on rounding matters."""
ROUNDING = 1e-12
"""Information over that of single parameters that is not told from none."""

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class ConvergenceLimits:
    """When a fit is given up: it does not converge to a model that describes the data.

    Parameters
    ----------
    misfit : float
        A fit that is better than this is followed to its end.
    gain : float
        A worse one must come to this share of its misfit ...
    every : int
        ... in so many steps.
    """

    misfit: float
    gain: float
    every: int


FIRST_PASS, LATER_PASS = ConvergenceLimits(3.0, 0.8, 6), ConvergenceLimits(1.3, 0.93, 4)
"""Until the modes beside the band are refined too, and afterwards."""


def fit_band(
    data: BandData,
    start: BandModel,
    max_steps: int = 60,
    convergence: ConvergenceLimits = FIRST_PASS,
    near: BandModel | None = None,
) -> BandFit:
    """Maximise the likelihood from a start near the maximum.

    Levenberg-damped Fisher scoring: the information matrix needs no second derivative.

    Parameters
    ----------
    data : BandData
        Of one band.
    start : BandModel
        With shapes of unit length and a positive definite force; the prior is centred on it.
    max_steps : int
        Scoring steps, those rejected included.
    convergence : ConvergenceLimits
        When to give up.
    near : BandModel or None
        A better place to begin, on which the prior is not centred.
    """
    # Far from the maximum numbers may overflow; such a step is rejected, not reported.
    with np.errstate(over='ignore', invalid='ignore', divide='ignore'):
        prior = Prior.of(start)
        begin, n_steps = near or start, 0
        if not begin.curvature:
            # A model that lacks a mode is led astray by a curvature: that comes last.
            straight = _fit_band(data, begin, prior.of_one_slope(), max_steps, convergence)
            if not (straight.converged and straight.misfit < convergence.misfit):
                return straight
            begin, n_steps = straight.model, straight.n_steps
        fit = _fit_band(data, begin, prior, max_steps, convergence)
        return replace(fit, n_steps=n_steps + fit.n_steps)


def value_at(data: BandData, model: BandModel, start: BandModel) -> float:
    """Return the negative logarithm of likelihood and priors, these centred on a start."""
    with np.errstate(over='ignore', invalid='ignore', divide='ignore'):
        found, _ = _evaluated(data, model, Prior.of(start))
    return np.inf if found is None else found.value


def mean_at(data: BandData, model: BandModel) -> Mean | None:
    """Return what known inputs explain; None where the model is no covariance."""
    found, _ = _evaluated(data, model, Prior.of(model))
    return None if found is None else found.mean


def with_spread(data: BandData, model: BandModel) -> BandData:
    """Return a band with what is fitted to it by chance as known inputs' doing."""
    mean = mean_at(data, model)
    if mean is None or data.known is None:
        return data
    known = replace(data.known, spread=mean.spread(data, data.known, model))
    return replace(data, known=known)


def bends(data: BandData, model: BandModel) -> float:
    """Return the chance of what known inputs leave, see :meth:`Mean.bends`."""
    found, model = _evaluated(data, model, Prior.of(model))
    if found is None or found.mean is None or data.known is None:
        return 0.0
    return found.mean.bends(data, data.known, model, found.whitening)


def _evaluated(
    data: BandData, model: BandModel, prior: Prior
) -> tuple[Evaluation | None, BandModel]:
    """Return a model against the data, without force below zero where that is no covariance."""
    found = evaluate(data, model, prior)
    if found is None and np.isfinite(model.force).all():
        model = without_negative(model)
        found = evaluate(data, model, prior)
    return found, model


def _fit_band(
    data: BandData, start: BandModel, prior: Prior, max_steps: int, convergence: ConvergenceLimits
) -> BandFit:
    damping, n_steps, converged = FIRST_DAMPING, 0, False
    current, model = _evaluated(data, start, prior)
    if current is None:
        unknown = np.full(start.n_free, np.nan)
        none = np.full((start.n_free, len(start.shapes), 0), np.nan + 0j)
        return BandFit(start, unknown, unknown, none, np.nan, False, 0, np.inf, np.inf)
    quadratic = quadratic_at(data, model, prior, current)
    misfit = np.inf
    while n_steps < max_steps and damping < LARGEST_DAMPING and not converged:
        n_steps += 1
        if n_steps % convergence.every == 0:
            before, misfit = misfit, _misfit(data, current)
            if misfit > convergence.misfit and misfit > convergence.gain * before:
                break
        candidate = moved(model, scoring_step(quadratic, damping))
        trial = evaluate(data, candidate, prior)
        if trial is not None and damping < NEARLY_UNDAMPED:
            converged = abs(trial.value - current.value) < LIKELIHOOD.converged_change
        if trial is None or trial.value > current.value:
            damping *= 10.0
            continue
        damping = max(damping / 4.0, LEAST_DAMPING)
        model, current = candidate, trial
        if not converged:  # so close, the information is the same
            quadratic = quadratic_at(data, model, prior, current)
    covariance = _covariance(quadratic.information)
    deviation = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    size = 2 * len(model.shapes)
    poles = deviation[: start.n_free * size].reshape(start.n_free, -1)
    slope_std = float(deviation[start.n_free * size + n_force_parameters(model)])
    scatter = _shape_scatter(covariance, model)
    misfit = _misfit(data, current)
    return BandFit(
        model,
        poles[:, 0],
        poles[:, 1],
        scatter,
        slope_std,
        converged,
        n_steps,
        misfit,
        current.value,
    )


def _covariance(information: Real) -> Real:
    """Return the covariance of the parameters; NaN where the information is no number."""
    scale = np.sqrt(np.diag(information))
    if not (np.isfinite(information).all() and np.all(scale > 0.0)):
        return np.full_like(information, np.nan)
    scaled = information / np.outer(scale, scale)
    factor, failed = dpotrf(scaled, lower=True)
    if failed or np.diag(factor).min() ** 2 < NEARLY_SINGULAR:
        # What nothing is known of has a large deviation, and not none.
        known, directions = np.linalg.eigh(scaled)
        covariance = (directions / np.maximum(known, ROUNDING)) @ directions.T
    else:
        lower = np.tril(dpotri(factor, lower=True)[0])
        covariance = lower + np.tril(lower, -1).T
    return np.asarray(covariance / np.outer(scale, scale))


def _shape_scatter(covariance: Real, model: BandModel) -> Complex:
    """Return the shapes' errors along the principal directions of their covariance."""
    n_channels = len(model.shapes)
    size = 2 * n_channels
    scatter = np.full((model.n_free, n_channels, size - 2), np.nan, dtype=complex)
    bases = across(model.shapes[:, : model.n_free])
    for mode in range(model.n_free):
        own = slice(mode * size + 2, (mode + 1) * size)
        block = covariance[own, own]
        if not np.isfinite(block).all():
            continue
        variance, directions = np.linalg.eigh(block)
        steps = directions * np.sqrt(np.maximum(variance, 0.0))
        scatter[mode] = bases[mode] @ (steps[::2] + 1j * steps[1::2])
    return scatter


def _misfit(data: BandData, at: Evaluation) -> float:
    """Return Σ n |residual|² over its expectation; a white Wishart average has E = r²/n."""
    squares = np.sum(np.abs(at.residual) ** 2, axis=(1, 2))
    n_channels = at.residual.shape[1]
    return float(np.sum(data.n_averaged * squares) / (len(squares) * n_channels**2))
