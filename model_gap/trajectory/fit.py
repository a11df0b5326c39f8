"""Weights of laws with their uncertainty and evidence: linear, Gaussian, scales unknown."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_gap.trajectory.problem import Layout, Sums
from model_gap.trajectory.term import Array

Index = NDArray[np.intp]
ROUNDS = 12
SETTLED = 1e-6


@dataclass(frozen=True)
class Fit:
    """Weights of some terms.

    Parameters
    ----------
    chosen : tuple of int
        Terms of the layout.
    columns : (n,) int array
        Columns they take.
    weights : (n,) array
        Of these columns.
    covariance : (n, n) array
        Of the weights.
    variance : (n_rows,) array
        Of the whitened residual of every row.
    evidence : float
        Log of the marginal likelihood, up to a constant that all fits of the same sums share.
    """

    chosen: tuple[int, ...]
    columns: Index
    weights: Array
    covariance: Array
    variance: Array
    evidence: float

    def of(self, layout: Layout, term: int) -> tuple[Array, Array]:
        """Return the weights of one term, and their covariance."""
        place = np.flatnonzero(np.isin(self.columns, np.r_[layout.places[term]]))
        return self.weights[place], self.covariance[np.ix_(place, place)]

    def full(self, layout: Layout) -> Array:
        """Return weights of all columns of a layout; zero where a term is not in."""
        weights = np.zeros(len(layout.scale))
        weights[self.columns] = self.weights
        return weights


def fit_terms(sums: Sums, layout: Layout, chosen: Sequence[int]) -> Fit:
    """Fit the weights of some terms with the scale of every row's noise.

    Parameters
    ----------
    sums : Sums
        Whitened normal equations.
    layout : Layout
        Prior of every column.
    chosen : sequence of int
        Terms.
    """
    columns = layout.columns_of(chosen)
    scale = layout.scale[columns]
    # In units of the prior: all numbers are of order one.
    gram = sums.gram[:, columns[:, None], columns] * np.outer(scale, scale)
    moment = sums.moment[:, columns] * scale
    variance = np.maximum(sums.square / sums.count, 1e-300)
    for _ in range(ROUNDS):
        precision = np.einsum('q,qij->ij', 1.0 / variance, gram) + np.eye(len(columns))
        factor = np.linalg.cholesky(precision)
        right = np.einsum('q,qi->i', 1.0 / variance, moment)
        weights = np.linalg.solve(factor.T, np.linalg.solve(factor, right))
        left = (
            sums.square - 2.0 * moment @ weights + np.einsum('i,qij,j->q', weights, gram, weights)
        )
        renewed = np.maximum(left, 1e-12 * sums.square) / sums.count
        change = np.abs(np.log(renewed / variance)).max(initial=0.0)
        variance = renewed
        if change < SETTLED:
            break
    evidence = (
        -0.5 * float(sums.count @ np.log(variance))
        - 0.5 * float(weights @ weights)
        - float(np.log(np.diag(factor)).sum())
    )
    inverse = np.linalg.inv(precision)
    return Fit(
        tuple(chosen),
        columns,
        weights * scale,
        inverse * np.outer(scale, scale),
        variance,
        evidence,
    )


def block_covariance(parts: Sequence[Sums], whole: Sums, layout: Layout, fit: Fit) -> Array:
    """Return the covariance of the weights as leaving out every block in turn shows it.

    A law that is a little wrong leaves residuals that agree with themselves for seconds; what
    they do to the weights is seen from block to block, whatever their correlation (the delete-one
    jackknife; Efron and Stein 1981).

    Parameters
    ----------
    parts : sequence of Sums
        Of the blocks.
    whole : Sums
        Of all data.
    layout, fit
        The terms and their fit.
    """
    scale = layout.scale[fit.columns]
    outer = np.outer(scale, scale)
    estimates = []
    for part in parts:
        rest = whole - part
        gram = np.einsum(
            'q,qij->ij', 1.0 / fit.variance, rest.gram[:, fit.columns[:, None], fit.columns]
        )
        right = np.einsum('q,qi->i', 1.0 / fit.variance, rest.moment[:, fit.columns])
        solved = np.linalg.solve(gram * outer + np.eye(len(scale)), right * scale)
        estimates.append(solved * scale)
    spread = np.array(estimates) - np.mean(estimates, axis=0)
    return np.asarray((len(parts) - 1.0) / len(parts) * spread.T @ spread)
