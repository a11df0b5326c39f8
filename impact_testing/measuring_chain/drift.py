"""A force whose rest drifts, as those of strain gauges and charge amplifiers do."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline
from scipy.stats import chi2

from impact_testing.record import ImpactRecord
from impact_testing.taps import ForceLevel

Real = NDArray[np.float64]
BLOCK_S = 0.5
"""A tap is so small a part of it that the median does not see it."""
FEWEST_BLOCKS = 4
"""Of a cubic spline."""
CHANCE = 1e-3
"""Of a force at rest whose blocks differ so much."""
OF_MEDIAN = 0.5 * np.pi
"""Variance of a median of Gaussian values to that of their mean."""


def without_drift(record: ImpactRecord) -> tuple[ImpactRecord, float]:
    """Return a record whose force rests at one level in each run, and by how much it drifted [N].

    Where the medians of blocks differ no more than noise makes them the record is as it was.
    """
    drifts = [drift_of(record.force_n[run.first : run.end], record.rate_hz) for run in record.runs]
    most = max(float(np.ptp(each)) for each in drifts)
    if not most:
        return record, 0.0
    return replace(record, force_n=record.force_n - np.concatenate(drifts)), most


def drift_of(force_n: Real, rate_hz: float) -> Real:
    """Return what a force reads at rest without its mean; zeros where that does not change."""
    n_blocks, none = int(len(force_n) / (BLOCK_S * rate_hz)), np.zeros(len(force_n))
    if n_blocks < FEWEST_BLOCKS:
        return none
    blocks = np.array_split(np.arange(len(force_n)), n_blocks)
    centre = np.array([rows.mean() for rows in blocks])
    level = np.array([np.median(force_n[rows]) for rows in blocks])
    course = make_interp_spline(centre, level - level.mean(), k=3)(np.arange(len(force_n)))
    noise_n = ForceLevel.of(force_n - course).noise_n
    least = OF_MEDIAN * noise_n**2 * n_blocks / len(force_n) * chi2.isf(CHANCE, n_blocks - 1)
    return np.asarray(course) if np.sum((level - level.mean()) ** 2) > least else none
