"""What the departures of one mode tell of a linear cause, without their scatter."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modal_history.alarm.baseline import Departures, estimate_variance, FARTHEST
from modal_history.alarm.wander import Wander

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Evidence:
    """Departures of a mode as a quadratic form: all that likelihoods need.

    Parameters
    ----------
    gram : (n_parts + 2, n_parts + 2) array
        Products of a constant, the sensitivities and the departures, each over its scatter.
    """

    gram: Array

    def misfit(
        self, part: int, change: Array, rough: float, rough_share: float
    ) -> tuple[Array, Array]:
        """Return what a change of one part leaves, and -2 log likelihood but for a constant.

        The model's sensitivity may be wrong by a factor, and by a constant over the poses: both
        are integrated out.

        Parameters
        ----------
        part : int
            Which.
        change : (n,) array
            Of the part.
        rough, rough_share : float
            Deviations of the factor from 1, and of the constant.
        """
        gram, row = self.gram, part + 1
        left = gram[-1, -1] - 2.0 * change * gram[row, -1] + change**2 * gram[row, row]
        # What is left, along the sensitivity and along a constant.
        along = gram[row, -1] - change * gram[row, row]
        level = gram[0, -1] - change * gram[row, 0]
        scale = np.stack([rough * change, rough_share * change], axis=-1)
        both = np.stack([along, level], axis=-1) * scale
        inner = gram[np.ix_([row, 0], [row, 0])]
        known = np.eye(2) + scale[:, :, None] * inner * scale[:, None, :]
        solved = np.linalg.solve(known, both[:, :, None])[:, :, 0]
        left = left - np.sum(both * solved, axis=-1)
        return left, left + np.linalg.slogdet(known)[1]

    def least(self, part: int) -> float:
        """Return what is left where the mode follows a part by a factor and a constant freely."""
        free = [0, part + 1]
        seen = self.gram[free, -1]
        solved = np.linalg.lstsq(self.gram[np.ix_(free, free)], seen, rcond=None)[0]
        return float(self.gram[-1, -1] - seen @ solved)


def evidence_of(found: Departures, wander: Wander, terms: Array) -> Evidence:
    """Return what departures tell, the scatter with its memory and the doubt of the usual out.

    Parameters
    ----------
    found : Departures
        Since a change began, by time.
    wander : Wander
        Scatter of the baseline.
    terms : (n, n_parts) array
        Change of the logarithm of the frequency for a unit change of each part.
    """
    trend = found.trend
    variance = estimate_variance(trend) + found.untold**2
    columns = np.column_stack(
        [np.ones(len(terms)), terms, _drawn_nearer(found, wander, variance), found.doubts]
    )
    time_s = (trend.time_ns - trend.time_ns[0]) / 1e9
    white, _ = wander.whitened(time_s, variance, columns)
    n_kept = terms.shape[1] + 2
    kept, doubts = white[:, :n_kept], white[:, n_kept:]
    cross = doubts.T @ kept
    known = np.eye(doubts.shape[1]) + doubts.T @ doubts
    gram = kept.T @ kept - cross.T @ np.linalg.solve(known, cross)
    return Evidence(gram)


def _drawn_nearer(found: Departures, wander: Wander, variance: Array) -> Array:
    """Return departures with outliers drawn nearer to their middle."""
    middle = float(np.median(found.away))
    doubt = np.sum(found.doubts**2, axis=1)
    # In other poses the same change moves the mode by nothing, or by twice as much.
    reach = FARTHEST * np.sqrt(variance + wander.size**2 + wander.white**2 + doubt) + abs(middle)
    return np.asarray(np.clip(found.away, middle - reach, middle + reach))
