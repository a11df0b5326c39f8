"""The Whittle likelihood of a band, maximised by Fisher scoring."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dpotrf, dpotri

from oma_identifier.likelihood.band_model import BandData, BandFit, BandModel
from oma_identifier.likelihood.force_prior import Prior
from oma_identifier.likelihood.scoring_step import moved, quadratic_at, scoring_step
from oma_identifier.likelihood.whittle import across, evaluate, Evaluation

CONVERGED_CHANGE = 0.01
"""Change of the log-likelihood at which no parameter moves by more than 0.14 of its deviation."""
NEARLY_UNDAMPED = 0.1
FIRST_DAMPING, LEAST_DAMPING, LARGEST_DAMPING = 1e-3, 1e-6, 1e6
NEARLY_SINGULAR = 1e-9
"""Share of a parameter's information that the others leave, from where on rounding matters."""

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
        return _fit_band(data, near or start, prior, max_steps, convergence)


def _fit_band(
    data: BandData, start: BandModel, prior: Prior, max_steps: int, convergence: ConvergenceLimits
) -> BandFit:
    model, damping, n_steps, converged = start, FIRST_DAMPING, 0, False
    current = evaluate(data, model, prior)
    if current is None and np.isfinite(start.force).all():
        model = replace(start, force=_without_negative(start.force))
        current = evaluate(data, model, prior)
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
            converged = abs(trial.value - current.value) < CONVERGED_CHANGE
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
    slope_std = float(deviation[start.n_free * size + len(start.force) ** 2])
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


def _without_negative(force: Complex) -> Complex:
    """Return a force with no power below zero.

    One band determines the forces of far tails badly: what it made of them may be no covariance
    beside the shapes of another pass.
    """
    power, directions = np.linalg.eigh(force)
    return np.asarray((directions * np.maximum(power, 0.0)) @ directions.conj().T)


def _covariance(information: Real) -> Real:
    """Return the covariance of the parameters; NaN where the information is no number."""
    scale = np.sqrt(np.diag(information))
    if not (np.isfinite(information).all() and np.all(scale > 0.0)):
        return np.full_like(information, np.nan)
    scaled = information / np.outer(scale, scale)
    factor, failed = dpotrf(scaled, lower=True)
    if failed or np.diag(factor).min() ** 2 < NEARLY_SINGULAR:
        covariance = np.linalg.pinv(scaled, rcond=1e-12, hermitian=True)
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
