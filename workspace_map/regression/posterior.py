"""What measured rows say about rows at other poses."""

from dataclasses import dataclass, replace

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
    before : Posterior, Shared or None
        Of another arm: the functions are its functions and a difference, of which `scales` are.
    """

    rows: Rows
    scales: Scales
    factor: Array
    weight: Array
    before: 'Posterior | Shared | None' = None

    def functions(self, q: Array) -> tuple[Array, ...]:
        """Return the posterior means of the unknown functions at a pose, one array per part.

        With another arm before, of what departs from its posterior means.
        """
        return self._pull(q, self.rows, self.weight)

    def pull(self, q: Array, rows: Rows, weight: Array) -> tuple[Array, ...]:
        """Return the posterior covariance of the functions at a pose with rows, times weights."""
        found = self._pull(q, rows, weight)
        if not len(self.rows):
            return found
        inner = self.prior(self.rows, rows) @ weight
        known = scipy.linalg.cho_solve((self.factor, True), inner, check_finite=False)
        seen = self._pull(q, self.rows, known)
        return tuple(a - b for a, b in zip(found, seen, strict=True))

    def prior(self, first: Rows, second: Rows) -> Array:
        """Return the covariance of rows before anything was measured, without white parts."""
        own = covariance(first, second, self.scales)
        return own if self.before is None else own + self.before.covariance(first, second)

    def covariance(self, first: Rows, second: Rows) -> Array:
        """Return the posterior covariance of rows without their white parts."""
        prior = self.prior(first, second)
        if not len(self.rows):
            return prior
        seen = self.seen(first)
        return np.asarray(prior - seen.T @ (seen if first is second else self.seen(second)))

    def seen(self, other: Rows) -> Array:
        """Return L⁻¹ Cov(measured, other), (n_measured, n_other)."""
        cross = self.prior(self.rows, other)
        found = scipy.linalg.solve_triangular(self.factor, cross, lower=True, check_finite=False)
        return np.asarray(found)

    def _pull(self, q: Array, rows: Rows, weight: Array) -> tuple[Array, ...]:
        """Return the prior covariance of the functions at a pose with rows, times weights."""
        if not len(rows):
            return tuple(np.zeros(part.shape[1]) for part in rows.parts)
        k = likeness(rows.q, q[None], self.scales.length)[rows.pose, 0]
        both = zip(self.scales.constant, self.scales.varying, strict=True)
        weights = [(c**2 + v**2 * k) * weight for c, v in both]
        found = tuple(w @ part for w, part in zip(weights, rows.parts, strict=True))
        if self.before is None:
            return found
        other = self.before.pull(q, rows, weight)
        return tuple(a + b for a, b in zip(found, other, strict=True))


@dataclass(frozen=True)
class Shared:
    """What a posterior of one arm tells of another that has parts of its own.

    Rows of the other arm do not depend on the first one's members of such parts: left out of
    them, these are averaged over.

    Parameters
    ----------
    whole : Posterior
        Of the first arm, with all its parts.
    own : tuple of int
        Parts that each arm has for itself.
    """

    whole: Posterior
    own: tuple[int, ...]

    def covariance(self, first: Rows, second: Rows) -> Array:
        """Return the posterior covariance of the other arm's rows without their white parts."""
        left = self._of_both(first)
        return self.whole.covariance(left, left if first is second else self._of_both(second))

    def pull(self, q: Array, rows: Rows, weight: Array) -> tuple[Array, ...]:
        """Return `Posterior.pull` for the other arm's rows; nothing in parts of its own."""
        found = self.whole.pull(q, self._of_both(rows), weight)
        return tuple(
            np.zeros_like(part) if number in self.own else part
            for number, part in enumerate(found)
        )

    def _of_both(self, rows: Rows) -> Rows:
        parts = tuple(
            np.zeros_like(part) if number in self.own else part
            for number, part in enumerate(rows.parts)
        )
        return replace(rows, parts=parts)


def posterior(
    rows: Rows,
    residual: Array,
    std: Array,
    scales: Scales,
    before: Posterior | Shared | None = None,
) -> Posterior:
    """Condition on measured rows.

    Parameters
    ----------
    rows : Rows
        What was measured.
    residual, std : (n_rows,) array
        Measured less what the prior's mean says, and the standard deviation of the measurement.
    scales : Scales
        Of the prior.
    before : Posterior or Shared, optional
        Of another arm, which this one differs from by what the prior says.
    """
    if not len(rows):
        return Posterior(rows, scales, np.zeros((0, 0)), np.zeros(0), before)
    whole = covariance(rows, rows, scales)
    if before is not None:
        whole += before.covariance(rows, rows)
    whole[np.diag_indices_from(whole)] += std**2 + scales.white[rows.kind] ** 2
    factor = np.asarray(np.linalg.cholesky(whole), dtype=float)
    weight = scipy.linalg.cho_solve((factor, True), residual, check_finite=False)
    return Posterior(rows, scales, factor, weight, before)
