"""What measured rows say about rows at other poses."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
import scipy.linalg

from workspace_map.regression.kernel import covariance, likeness, Rows
from workspace_map.regression.scales import Scales

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Posterior:
    """Measured rows, conditioned on.

    Parameters
    ----------
    rows : Rows
        That were measured.
    scales : Scales
        Of the prior.
    factor : (n_rows, n_rows) array
        Lower Cholesky factor of their covariance.
    weight : (n_rows,) array
        Covariance⁻¹ times residual.
    """

    rows: Rows
    scales: Scales
    factor: Array
    weight: Array

    def functions(self, q: Array) -> tuple[Array, ...]:
        """Return the posterior means of the unknown functions at a pose, one array per part."""
        if not len(self.rows):
            return tuple(np.zeros(part.shape[1]) for part in self.rows.parts)
        k = likeness(self.rows.q, q[None], self.scales.length)[self.rows.pose, 0]
        both = zip(self.scales.constant, self.scales.varying, strict=True)
        weights = [(c**2 + v**2 * k) * self.weight for c, v in both]
        return tuple(w @ part for w, part in zip(weights, self.rows.parts, strict=True))

    def covariance(self, first: Rows, second: Rows) -> Array:
        """Return the posterior covariance of rows without their white parts."""
        prior = covariance(first, second, self.scales)
        if not len(self.rows):
            return prior
        seen = self.seen(first)
        return np.asarray(prior - seen.T @ (seen if first is second else self.seen(second)))

    def seen(self, other: Rows) -> Array:
        """Return L⁻¹ Cov(measured, other), (n_measured, n_other)."""
        cross = covariance(self.rows, other, self.scales)
        found = scipy.linalg.solve_triangular(self.factor, cross, lower=True, check_finite=False)
        return np.asarray(found)


def posterior(rows: Rows, residual: Array, std: Array, scales: Scales) -> Posterior:
    """Condition on measured rows.

    Parameters
    ----------
    rows : Rows
        What was measured.
    residual, std : (n_rows,) array
        Measured less what the prior's mean says, and the standard deviation of the measurement.
    scales : Scales
        Of the prior.
    """
    if not len(rows):
        return Posterior(rows, scales, np.zeros((0, 0)), np.zeros(0))
    whole = covariance(rows, rows, scales)
    whole[np.diag_indices_from(whole)] += std**2 + scales.white[rows.kind] ** 2
    factor = np.asarray(np.linalg.cholesky(whole), dtype=float)
    weight = scipy.linalg.cho_solve((factor, True), residual, check_finite=False)
    return Posterior(rows, scales, factor, weight)
