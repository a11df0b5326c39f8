"""Whether a mode is found no more, where and when it used to be found."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree
from scipy.special import betaln

from modal_history.alarm.covariates import coordinates_of, Covariates
from modal_history.trend import Trend

Array = NDArray[np.float64]
NEIGHBOURS, USUAL = 8, 7
"""A window counts where the mode was found in so many of its nearest windows of the baseline."""
LONGEST_RUN = 10_000
"""Windows in a row after which any mode is lost: a week at one a minute."""


@dataclass(frozen=True, slots=True)
class Presence:
    """Where a mode used to be found, and how often it was missed there.

    Parameters
    ----------
    covariates : Covariates
        What joints and load are compared by.
    places : KDTree or None
        Poses and loads of the baseline; None where they were always the same.
    found : (n,) array of bool
        Whether the mode was found there.
    reach : float
        Distance beyond which nothing is known.
    begins : float
        Chance that a run of misses begins.
    went_on, ended : int
        Misses followed by a miss; by the mode.
    step_s : float [s]
        From window to window.
    """

    covariates: Covariates
    places: KDTree | None
    found: NDArray[np.bool_]
    reach: float
    begins: float
    went_on: int
    ended: int
    step_s: float

    def counts(self, heard: Trend) -> NDArray[np.bool_]:
        """Return in which windows the mode ought to be found."""
        if self.places is None:
            return np.full(len(heard), bool(self.found.mean() >= USUAL / NEIGHBOURS))
        where = coordinates_of(heard, self.covariates.joints, self.covariates.load)
        known = np.asarray(np.isfinite(where).all(axis=1))
        found = self.places.query(np.where(known[:, None], where, 0.0), k=NEIGHBOURS)
        away, near = (np.asarray(part) for part in found)
        usual = self.found[near].sum(axis=1) >= USUAL
        return np.asarray(known & usual & (away.max(axis=1) <= self.reach))

    def longest(self, false: float, of_s: float) -> int:
        """Return how many misses in a row there must be, for so many false ones in some time.

        Misses follow a chain of two states, whose chances are known as well as the baseline tells
        (uniform before): a run begins with one, goes on with the other.
        """
        more = np.arange(LONGEST_RUN)
        usual = betaln(self.went_on + 1 + more, self.ended + 1)
        chance = np.exp(usual - betaln(self.went_on + 1, self.ended + 1))
        looks = of_s / self.step_s
        enough = looks * self.begins * chance <= false
        return int(np.argmax(enough)) + 1 if enough.any() else LONGEST_RUN


def presence_of(heard: Trend, trend: Trend, covariates: Covariates) -> Presence | None:
    """Return where a mode used to be found; None where that is too seldom to miss it.

    Parameters
    ----------
    heard : Trend
        Windows of the baseline in which any mode was found.
    trend : Trend
        Those of them in which this one was.
    covariates : Covariates
        Of the mode's baseline.
    """
    found = np.isin(heard.time_ns, trend.time_ns)
    where = coordinates_of(heard, covariates.joints, covariates.load)
    known = np.isfinite(where).all(axis=1)
    if np.count_nonzero(known) <= NEIGHBOURS:
        return None
    places = KDTree(where[known]) if where.shape[1] else None
    reach = 0.0
    if places is not None:
        reach = float(np.max(places.query(where[known], NEIGHBOURS)[0]))
    step_s = max(float(np.median(np.diff(heard.time_ns))) / 1e9, 1e-3)
    first = Presence(covariates, places, found[known], reach, 0.0, 0, 0, step_s)
    seen = found[first.counts(heard)]
    if len(seen) <= NEIGHBOURS:
        return None
    before, after = seen[:-1], seen[1:]
    begins = (np.count_nonzero(before & ~after) + 1) / (np.count_nonzero(before) + 2)
    return replace(
        first,
        begins=float(begins),
        went_on=int(np.count_nonzero(~before & ~after)),
        ended=int(np.count_nonzero(~before & after)),
    )
