"""What is usual for a mode: its dependence on pose, load, temperature, and what scatters."""

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve, solve_triangular
from scipy.optimize import minimize

from modal_history.alarm.covariates import Covariates, covariates_of
from modal_history.alarm.wander import Wander
from modal_history.trend import Trend

Array = NDArray[np.float64]
MOST_LEARNT = 2000
"""Results that a baseline is learnt from, evenly taken: more do not tell more of its slow part."""
FARTHEST = 4.0
"""A result further away, in its standard deviations, counts as if it were so far."""
UNKNOWN_STD = 0.005
"""Relative deviation of a frequency that comes without one."""
LEAST_STD = 1e-6
REACHES = (0.5, 1.0, 2.0, 4.0)
"""Of places: from a function with a hill in each radian to one that hardly bends."""
AMPLITUDE, LARGEST_AMPLITUDE = 0.1, 1.0
"""Share of a frequency that pose and load are worth: to begin with, and at most."""
SPAN_SHARE = 0.25
"""Longest memory that a baseline can tell, as a share of its length."""


@dataclass(frozen=True)
class BaselineSettings:
    """How long is learnt.

    Parameters
    ----------
    days : float
        Length of the baseline [days]; a week holds what a plant does daily and on Sundays.
    n_least : int
        Results that are needed at least.
    """

    days: float = 7.0
    n_least: int = 50


@dataclass(frozen=True, slots=True)
class Baseline:
    """What is usual for a mode.

    Parameters
    ----------
    covariates : Covariates
        What it depends on.
    factors : (n_terms,) array
        Of its terms.
    root : (n_terms, n_terms) array
        Lower Cholesky factor of the factors' precision.
    wander : Wander
        What scatters beside the estimates.
    amplitude : float
        Share of the frequency that pose and load are worth.
    memory_n : float
        Independent stretches of the wandering part that the baseline holds.
    n : int
        Results learnt from.
    end_ns : int [ns]
        When it ends.
    """

    covariates: Covariates
    factors: Array
    root: Array
    wander: Wander
    amplitude: float
    memory_n: float
    n: int
    end_ns: int

    def departures(self, trend: Trend) -> 'Departures':
        """Return how far estimates are from what is usual, and how well that is known."""
        terms = self.covariates.terms(trend)
        known = np.isfinite(terms).all(axis=1)
        terms = terms[known]
        return Departures(
            trend=trend.rows(np.flatnonzero(known)),
            away=np.log(trend.frequency_hz[known]) - terms @ self.factors,
            doubts=np.ascontiguousarray(solve_triangular(self.root, terms.T, lower=True).T),
            untold=self.amplitude * np.sqrt(self.covariates.untold(terms)),
            cell=self.covariates.nearest(terms),
        )


@dataclass(frozen=True, slots=True)
class Departures:
    """How far results are from what is usual.

    Parameters
    ----------
    trend : Trend
        Those of which all covariates are known.
    away : (n,) array
        Of the logarithm of the frequency.
    doubts : (n, n_terms) array
        Independent parts of what is not known of the usual: those of a mean are their mean, and
        its variance is the sum of their squares.
    untold : (n,) array
        Deviation of what the baseline's places do not tell.
    cell : (n,) array of int
        The place each is nearest to: what is not told of results near one place they share, of
        others it is their own.
    """

    trend: Trend
    away: Array
    doubts: Array
    untold: Array
    cell: NDArray[np.int64]

    def at(self, rows: NDArray[np.intp]) -> 'Departures':
        """Return some of them."""
        names = ('away', 'doubts', 'untold', 'cell')
        return Departures(self.trend.rows(rows), *(getattr(self, name)[rows] for name in names))

    def since(self, row: int) -> 'Departures':
        """Return those from a row on."""
        return self.at(np.arange(row, len(self.away)))

    def until(self, row: int) -> 'Departures':
        """Return those before a row."""
        return self.at(np.arange(row))


def estimate_variance(trend: Trend) -> Array:
    """Return the variance of the logarithm of each estimate."""
    share = trend.frequency_std_hz / trend.frequency_hz
    share = np.where(np.isfinite(share), np.maximum(share, LEAST_STD), UNKNOWN_STD)
    return np.asarray(share**2)


def learn(trend: Trend, settings: BaselineSettings | None = None) -> Baseline | None:
    """Learn what is usual from the beginning of a trend; None while that is too short.

    Dependence and scatter are fitted together by the largest evidence, factors integrated out
    (MacKay, 1992, doi:10.1162/neco.1992.4.3.415), with results further away than
    :data:`FARTHEST` drawn nearer.
    """
    settings = settings or BaselineSettings()
    if not len(trend):
        return None
    end_ns = int(trend.time_ns[0]) + round(settings.days * 86_400e9)
    inside = np.flatnonzero(trend.time_ns <= end_ns)
    if trend.time_ns[-1] < end_ns or len(inside) < settings.n_least:
        return None
    learnt = trend.rows(inside[:: math.ceil(len(inside) / MOST_LEARNT)])
    known = np.isfinite(covariates_of(learnt, REACHES[0]).terms(learnt)).all(axis=1)
    if np.count_nonzero(known) < settings.n_least:
        return None
    learnt = learnt.rows(np.flatnonzero(known))
    fits = [_Fit(learnt, covariates_of(learnt, reach)) for reach in REACHES]
    return min(fits, key=_Fit.at_first).best(end_ns)


class _Fit:
    """A baseline with one reach of the places."""

    def __init__(self, trend: Trend, covariates: Covariates) -> None:
        self.covariates, self.terms = covariates, covariates.terms(trend)
        self.time_s = (trend.time_ns - trend.time_ns[0]) / 1e9
        self.variance = estimate_variance(trend)
        self.value = np.log(trend.frequency_hz)
        self.untold = covariates.untold(self.terms)
        self.span_s = max(float(self.time_s[-1]), 1.0)
        usual = math.sqrt(float(np.median(self.variance)))
        # Size, memory and white part of the scatter, amplitude of the places.
        self.start = np.log([usual, 0.02 * self.span_s, usual, AMPLITUDE])

    def at_first(self) -> float:
        """Return the evidence before any fit."""
        return self.evidence(self.start)

    def best(self, end_ns: int) -> Baseline:
        """Return the baseline of the largest evidence."""
        logs = self.start
        for _ in range(2):
            found = minimize(
                self.evidence, logs, method='Nelder-Mead', options={'maxfev': 120, 'xatol': 0.02}
            )
            logs = found.x
            wander, amplitude = self.scatter(logs)
            factors, root = self.solve(wander, amplitude)[:2]
            limit = FARTHEST * np.sqrt(self.variance + wander.white**2 + wander.size**2)
            usual = self.terms @ factors
            self.value = usual + np.clip(self.value - usual, -limit, limit)
        stretches = self.span_s / (2.0 * wander.memory_s)
        return Baseline(
            self.covariates, factors, root, wander, amplitude, stretches, len(usual), end_ns
        )

    def scatter(self, logs: Array) -> tuple[Wander, float]:
        """Return the scatter and the amplitude that a point of the search means."""
        size, memory_s, white, amplitude = np.exp(np.clip(logs, -25.0, 25.0)).tolist()
        # A scatter that outlasts the baseline cannot be told from what it depends on.
        memory_s = min(memory_s, SPAN_SHARE * self.span_s)
        return Wander(size, memory_s, white), min(amplitude, LARGEST_AMPLITUDE)

    def evidence(self, logs: Array) -> float:
        """Return -2 log of the probability of the data, but for a constant."""
        wander, amplitude = self.scatter(logs)
        _, root, left, log = self.solve(wander, amplitude)
        prior = float(np.log(self.covariates.precision(amplitude)).sum())
        return left + log + 2.0 * float(np.log(np.diag(root)).sum()) - prior

    def solve(self, wander: Wander, amplitude: float) -> tuple[Array, Array, float, float]:
        """Return factors, the root of their precision, what is left, the log determinant."""
        variance = self.variance + amplitude**2 * self.untold
        columns = np.column_stack([self.terms, self.value])
        both, log = wander.whitened(self.time_s, variance, columns)
        white, seen = both[:, :-1], both[:, -1]
        precision = np.diag(self.covariates.precision(amplitude))
        root = cho_factor(white.T @ white + precision, lower=True)
        factors = cho_solve(root, white.T @ seen)
        left = float(seen @ (seen - white @ factors))
        return factors, np.tril(root[0]), left, log
