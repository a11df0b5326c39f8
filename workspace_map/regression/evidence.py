"""Scales by marginal likelihood, with log-normal priors, exact gradients and restarts."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
import scipy.linalg
from scipy.optimize import minimize

from workspace_map.regression.kernel import likeness, likeness_slopes, Rows
from workspace_map.regression.scales import Scales

Array = NDArray[np.float64]
LARGEST_SHIFT = 6.0
"""Of a logarithm from its prior median, in standard deviations: keeps the search finite."""


@dataclass(frozen=True)
class Evidence:
    """Negative log marginal likelihood of measured rows, and of the scales' prior.

    Parameters
    ----------
    rows : Rows
        That were measured.
    residual, std : (n_rows,) array
        As in `posterior`.
    prior : Scales
        Medians.
    spread : float
        Standard deviation of the logarithms.
    grams : tuple of (n_rows, n_rows) array
        Products of the rows, per part.
    known : (n_rows, n_rows) array
        Covariance of the rows that no scale changes: what is not known of another arm.
    """

    rows: Rows
    residual: Array
    std: Array
    prior: Scales
    spread: float
    grams: tuple[Array, ...]
    known: Array

    def at(self, logs: Array) -> tuple[float, Array]:
        """Return the value and its gradient at some logarithms of the scales."""
        scales = self.prior.with_logs(logs)
        rows = self.rows
        at = rows.pose[:, None], rows.pose
        k = likeness(rows.q, rows.q, scales.length)[at]
        varying = self._sum(scales.varying)
        whole = self._sum(scales.constant) + varying * k + self.known
        white = scales.white[rows.kind] ** 2
        whole[np.diag_indices_from(whole)] += self.std**2 + white
        factor = np.linalg.cholesky(whole)
        weight = scipy.linalg.cho_solve((factor, True), self.residual, check_finite=False)
        inverse = scipy.linalg.cho_solve((factor, True), np.eye(len(rows)), check_finite=False)
        value = 0.5 * self.residual @ weight + np.sum(np.log(np.diag(factor)))
        pull = 0.5 * (inverse - np.outer(weight, weight))
        along = [*self._slopes(scales.constant, pull), *self._slopes(scales.varying, pull * k)]
        own = 2.0 * np.diag(pull) * white
        along += list(np.bincount(rows.kind, own, minlength=len(scales.white)))
        # By pose first: the lengths' derivatives are the same for all rows of two poses.
        met = _between_poses(pull * varying, rows.pose, len(rows.q))
        along += list(np.tensordot(likeness_slopes(rows.q, scales.length), met, 2))
        free = np.concatenate([scales.constant, scales.varying, scales.white, scales.length]) > 0.0
        off = (logs - self.prior.logs()) / self.spread
        return float(value + 0.5 * off @ off), np.array(along)[free] + off / self.spread

    def _slopes(self, sizes: Array, pull: Array) -> list[float]:
        each = zip(sizes, self.grams, strict=True)
        return [float(2.0 * size**2 * np.sum(pull * gram)) for size, gram in each]

    def _sum(self, sizes: Array) -> Array:
        found = np.zeros((len(self.rows), len(self.rows)))
        for size, gram in zip(sizes, self.grams, strict=True):
            if size > 0.0:
                found += size**2 * gram
        return found


def evidence_of(
    rows: Rows,
    residual: Array,
    std: Array,
    prior: Scales,
    spread: float,
    known: Array | None = None,
) -> Evidence:
    """Return the marginal likelihood to maximise; see `Evidence`."""
    grams = tuple(part @ part.T for part in rows.parts)
    fixed = np.zeros((len(rows), len(rows))) if known is None else known
    return Evidence(rows, residual, std, prior, spread, grams, fixed)


def most_probable_scales(
    evidence: Evidence, start: Scales, restarts: int = 2, steps: int = 60
) -> Scales:
    """Return the scales of greatest marginal likelihood times prior.

    Parameters
    ----------
    evidence : Evidence
        Of the measured rows.
    start : Scales
        Where one search begins.
    restarts : int
        Further searches from points of the prior, the same each time.
    steps : int
        Of each search at most.
    """
    centre, spread = evidence.prior.logs(), evidence.spread
    draws = np.random.default_rng(0).standard_normal((restarts, len(centre)))
    bounds = [(c - LARGEST_SHIFT * spread, c + LARGEST_SHIFT * spread) for c in centre]
    found = [
        minimize(
            evidence.at, begin, jac=True, method='L-BFGS-B', bounds=bounds,
            options={'maxiter': steps},
        )
        for begin in (start.logs(), *(centre + spread * draws))
    ]  # fmt: skip
    return evidence.prior.with_logs(min(found, key=lambda each: float(each.fun)).x)


def _between_poses(matrix: Array, pose: NDArray[np.intp], n_poses: int) -> Array:
    """Return the sums of a matrix over the rows of two poses, (n_poses, n_poses)."""
    member = np.zeros((n_poses, len(pose)))
    member[pose, np.arange(len(pose))] = 1.0
    return np.asarray(member @ matrix @ member.T)
