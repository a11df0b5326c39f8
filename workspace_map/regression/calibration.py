"""By how much posterior deviations are too large or too small, from poses left out."""

import numpy as np
from numpy.typing import NDArray
import scipy.linalg
from scipy.optimize import minimize_scalar

from workspace_map.regression.posterior import Posterior

Array = NDArray[np.float64]
FEWEST_POSES = 4
SPREAD, LARGEST = 0.5, 1.5
"""Standard deviation of the factor's logarithm beforehand, and the largest that is looked at."""


def deviation_factor(found: Posterior, residual: Array, std: Array, kind: int) -> float:
    """Return the factor on posterior standard deviations that poses left out ask for.

    Every pose is predicted from all others in turn, in closed form (Rasmussen and Williams 2006,
    section 5.4.2, by whole poses).  What is off is the measurement's noise, which is known, and
    the map's own error, whose factor is most probable.  One scale for all springs is a guess that
    this checks.

    Parameters
    ----------
    found : Posterior
        Of all poses.
    residual, std : (n_rows,) array
        As in `posterior`.
    kind : int
        Kind of the rows that are judged.
    """
    poses = np.unique(found.rows.pose)
    if len(poses) < FEWEST_POSES:
        return 1.0
    inverse = scipy.linalg.cho_solve((found.factor, True), np.eye(len(residual)))
    left_out = []
    for pose in poses:
        rows = np.flatnonzero(found.rows.pose == pose)
        judged = found.rows.kind[rows] == kind
        own = np.linalg.inv(inverse[np.ix_(rows, rows)])
        noise = np.diag(std[rows[judged]] ** 2)
        off = (own @ found.weight[rows])[judged]
        # Rotated so that noise is one and the map's error is diagonal.
        root = np.linalg.inv(np.sqrt(noise))
        size, turn = np.linalg.eigh(root @ (own[np.ix_(judged, judged)] - noise) @ root)
        left_out.append((np.maximum(size, 0.0), turn.T @ root @ off))
    sizes, offs = (np.concatenate(each) for each in zip(*left_out, strict=True))

    def cost(log_factor: float) -> float:
        variance = 1.0 + np.exp(2.0 * log_factor) * sizes
        fit = np.sum(offs**2 / variance + np.log(variance))
        return float(0.5 * fit + 0.5 * (log_factor / SPREAD) ** 2)

    found_at = minimize_scalar(cost, bounds=(-LARGEST, LARGEST), method='bounded')
    return float(np.exp(found_at.x))
