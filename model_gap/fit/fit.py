"""Maximum a posteriori fit of effects and tolerances to complex spectra, and its evidence.

The likelihood is tempered: bins of one record are correlated and the model is never exact, so the
data count as ``effective_data`` independent pieces of unknown scale,
-log L = N log χ with χ = mean |Y - Ŷ|²/σ².
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import ModelError
from model_gap.campaign import Rows
from model_gap.effects import Effect
from model_gap.fit.linearise import effect_columns, tolerance_columns
from model_gap.fit.plausible import cost, weight
from model_gap.fit.thresholds import FIT
from model_gap.hypothesis import Hypothesis
from model_gap.predict import Predictor

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Linearised:
    """How tolerances act at a point.

    Parameters
    ----------
    at : Hypothesis
        Where.
    columns : (n_tolerances, n_rows) array
        Derivatives, per prior standard deviation.
    """

    at: Hypothesis
    columns: Rows

    @classmethod
    def of(cls, hypothesis: Hypothesis, predictor: Predictor) -> 'Linearised':
        """Linearise where a hypothesis is."""
        return cls(hypothesis, tolerance_columns(hypothesis, predictor))

    def is_of(self, hypothesis: Hypothesis) -> bool:
        """Return whether a hypothesis has the same effects with as many numbers."""
        keys, others = ([item.key for item in it.effects] for it in (self.at, hypothesis))
        return keys == others and len(self.at.inner) == len(hypothesis.inner)


@dataclass(frozen=True)
class Fit:
    """A fitted hypothesis.

    Parameters
    ----------
    hypothesis : Hypothesis
        At its most probable values.
    misfit : float
        χ on the records it was fitted to.
    log_evidence : float
        Tempered, by Laplace's method, up to a constant of the data.
    covariance : (n_parameters, n_parameters) array
        Of the inner parameters, tolerances marginalised.
    precision : (n_tolerances + n_parameters, same) array
        Of all numbers, in prior standard deviations.
    linearised : Linearised or None
        Near it, where that was kept.
    """

    hypothesis: Hypothesis
    misfit: float
    log_evidence: float
    covariance: Array
    precision: Array
    linearised: Linearised | None = field(default=None, repr=False)

    @property
    def without_columns(self) -> 'Fit':
        """The fit without what is large."""
        return replace(self, linearised=None)


@dataclass(frozen=True)
class Descent:
    """Where damped Gauss-Newton steps led.

    Parameters
    ----------
    hypothesis : Hypothesis
        There.
    misfit : float
        χ there.
    objective : float
        Minus the log posterior density there, up to a constant.
    gain : float
        How much lower that is than where they began.
    """

    hypothesis: Hypothesis
    misfit: float
    objective: float
    gain: float


@dataclass(frozen=True)
class Stride:
    """A step that was taken.

    Parameters
    ----------
    step : (n_tolerances + n_parameters,) array
        In prior standard deviations.
    hypothesis : Hypothesis
        Where it leads.
    rows : (n_rows,) array
        The prediction there.
    misfit : float
        χ there.
    value : float
        What became less.
    """

    step: Array
    hypothesis: Hypothesis
    rows: Rows
    misfit: float
    value: float


def objective(misfit_value: float, hypothesis: Hypothesis) -> float:
    """Return minus the log posterior density, up to a constant."""
    tolerances = 0.5 * float(hypothesis.tolerance_values @ hypothesis.tolerance_values)
    return float(FIT.effective_data * np.log(misfit_value) + tolerances + cost(hypothesis.scaled))


def free_numbers_cost(effects: Sequence[Effect], records: int) -> float:
    """Return what numbers that are free in every record cost in log evidence.

    Half the logarithm of the data's count each: Schwarz (1978), doi:10.1214/aos/1176344136.
    """
    count = records * sum(effect.free_numbers for effect in effects)
    return float(0.5 * np.log(FIT.effective_data) * count)


def fit(
    hypothesis: Hypothesis,
    predictor: Predictor,
    linearised: Linearised | None = None,
    iterations: int = 8,
    relinearise: int = 1,
) -> Fit:
    """Fit by damped Gauss-Newton steps.

    Parameters
    ----------
    hypothesis : Hypothesis
        Start.
    predictor : Predictor
        Of the fitting records.
    linearised : Linearised
        To begin with, and to end with if it is of the same effects; computed when missing.
    iterations : int
        Most steps between two linearisations of the tolerances.
    relinearise : int
        How often the tolerances are linearised anew at most.
    """
    linearised = linearised or Linearised.of(hypothesis, predictor)
    near = linearised.is_of(hypothesis)
    for left in range(relinearise, -1, -1):
        down = descend(hypothesis, predictor, linearised.columns, iterations)
        hypothesis = down.hypothesis
        near = near and down.gain < FIT.little_gain
        if near or not left:
            break
        linearised, near = Linearised.of(hypothesis, predictor), True
    return _summary(down, predictor, linearised, near)


def descend(
    hypothesis: Hypothesis,
    predictor: Predictor,
    columns: Rows,
    iterations: int,
) -> Descent:
    """Go down by damped Gauss-Newton steps, tolerances linear as ``columns`` say.

    Raises
    ------
    ModelError
        What the arm does where it begins is beyond all numbers: no step leads away from there.
    """
    rows = predictor.rows(hypothesis.cell())
    chi = predictor.weighting.misfit(rows)
    if not np.isfinite(chi):
        raise ModelError('response grows beyond all numbers', found=list(hypothesis.effects))
    best = first = objective(chi, hypothesis)
    gram = np.asarray(columns @ columns.T, dtype=float)
    for _ in range(iterations):
        step = _step(hypothesis, predictor, columns, gram, rows, chi)
        there = lower(
            hypothesis, step, predictor, best, lambda _, moved, chi: objective(chi, moved)
        )
        if there is None:
            break
        gain, best = best - there.value, there.value
        hypothesis, rows, chi = there.hypothesis, there.rows, there.misfit
        if gain < 0.3:
            break
    return Descent(hypothesis, chi, best, first - best)


def lower(
    hypothesis: Hypothesis,
    step: Array,
    predictor: Predictor,
    least: float,
    value: Callable[[Array, Hypothesis, float], float],
) -> Stride | None:
    """Return where a step, or else a shorter one, leads lower; None where none does.

    Parameters
    ----------
    hypothesis : Hypothesis
        Where the step begins.
    step : (n_tolerances + n_parameters,) array
        In prior standard deviations.
    predictor : Predictor
        Of the records.
    least : float
        What is to be undercut.
    value : callable
        Takes the step taken, where it leads and χ there.
    """
    for share in FIT.trials:
        moved = hypothesis.stepped(share * step)
        try:
            rows = predictor.rows(moved.cell())
        except ModelError:
            continue  # not a possible arm: a shorter step
        chi = predictor.weighting.misfit(rows)
        found = value(share * step, moved, chi)
        if found < least:
            return Stride(share * step, moved, rows, chi, found)
    return None


def _step(
    hypothesis: Hypothesis,
    predictor: Predictor,
    columns: Rows,
    gram: Array,
    rows: Rows,
    chi: float,
) -> Array:
    """Return the Gauss-Newton step in prior standard deviations, tolerances first."""
    extra = effect_columns(hypothesis, predictor, rows)
    residual = predictor.weighting.measured - rows
    prior = prior_precision(hypothesis)
    hessian = posterior_hessian(columns, gram, extra, chi, predictor.weighting.count, prior)
    data = FIT.effective_data / (predictor.weighting.count * chi) * 2.0
    pull = np.r_[columns @ residual, extra @ residual].astype(float) * data
    here = np.r_[hypothesis.tolerance_values, hypothesis.scaled]
    return _inside(hypothesis, hessian, pull - prior * here)


def _inside(hypothesis: Hypothesis, hessian: Array, pull: Array) -> Array:
    """Solve for the step; numbers at a bound that it would leave stay, and the rest makes up.

    Bertsekas (1982), doi:10.1137/0320018: a step that is cut off at a bound afterwards may lead up
    however short it is made.
    """
    free = np.ones(len(pull), dtype=bool)
    while True:
        step = np.zeros(len(pull))
        step[free] = np.linalg.solve(hessian[np.ix_(free, free)], pull[free])
        stuck = free & hypothesis.leaves(step)
        if not stuck.any():
            return step
        free &= ~stuck


def prior_precision(hypothesis: Hypothesis) -> Array:
    """Return the prior's curvature for all numbers, tolerances first: these are normal."""
    own = np.ones(len(hypothesis.tolerance_values))
    return np.asarray(np.r_[own, weight(hypothesis.scaled)])


def posterior_hessian(
    columns: Rows, gram: Array, extra: Rows, chi: float, count: int, prior: Array
) -> Array:
    """Return minus the second derivative of the log posterior in prior standard deviations."""
    data = FIT.effective_data / (count * chi) * 2.0
    cross = np.asarray(columns @ extra.T, dtype=float)
    own = np.asarray(extra @ extra.T, dtype=float)
    hessian = data * np.block([[gram, cross], [cross.T, own]])
    hessian[np.diag_indices_from(hessian)] += prior
    return hessian


def _summary(down: Descent, predictor: Predictor, linearised: Linearised, near: bool) -> Fit:
    """Return the fit; what acts alike, an effect and a tolerance, is linearised at one point."""
    hypothesis, chi, columns = down.hypothesis, down.misfit, linearised.columns
    at = linearised.at if near else hypothesis
    extra = effect_columns(at, predictor, predictor.rows(at.cell()))
    gram = np.asarray(columns @ columns.T, dtype=float)
    prior = prior_precision(hypothesis)
    hessian = posterior_hessian(columns, gram, extra, chi, predictor.weighting.count, prior)
    covariance = np.linalg.inv(hessian)[len(columns) :, len(columns) :]
    scale = hypothesis.prior_scale
    evidence = -down.objective - 0.5 * float(np.linalg.slogdet(hessian)[1])
    evidence -= free_numbers_cost(hypothesis.effects, len(predictor.records))
    return Fit(
        hypothesis=hypothesis,
        misfit=chi,
        log_evidence=evidence,
        covariance=covariance * np.outer(scale, scale),
        precision=hessian,
        linearised=linearised if near else None,
    )
