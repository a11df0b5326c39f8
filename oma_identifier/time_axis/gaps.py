"""Gaps: samples that never came, and values that are no measurement."""

import numpy as np
from numpy.typing import NDArray

from oma_identifier.time_axis.resample import AR_ORDER, fill_gaps
from oma_identifier.time_axis.thresholds import TIME_AXIS

Real = NDArray[np.float64]
Mask = NDArray[np.bool_]


def longest_filled(period_ns: float) -> int:
    """Return how many missing samples in a row are filled."""
    return max(TIME_AXIS.fewest_filled, int(TIME_AXIS.longest_filled_s * 1e9 / period_ns))


def no_measurement(values: NDArray[np.floating]) -> Mask:
    """Return which values are not finite, or larger than anything an accelerometer tells."""
    # False for NaN, and much quicker where all are well.
    if not values.size or (
        values.min() >= -TIME_AXIS.largest_value and values.max() <= TIME_AXIS.largest_value
    ):
        return np.zeros(values.shape, dtype=bool)
    return np.asarray(~(np.abs(values) <= TIME_AXIS.largest_value))


def measured(values: NDArray[np.floating]) -> NDArray[np.floating]:
    """Return values, those that are no measurement as NaN; the very same array where all are."""
    bad = no_measurement(values)
    return np.where(bad, np.array(np.nan, values.dtype), values) if bad.any() else values


def long_runs(mask: Mask, longest: int) -> Mask:
    """Return the mask with runs up to ``longest`` removed."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    long = mask.copy()
    for start, stop in zip(edges[::2], edges[1::2], strict=True):
        if stop - start <= longest:
            long[start:stop] = False
    return long


def fill_short(values: Real, missing: Mask, lost: Mask) -> Real:
    """Fill short gaps from the stretch between two long ones.

    Parameters
    ----------
    values : (n_samples, n_channels) array
        What stands at missing places does not matter.
    missing, lost : (n_samples,) bool array
        Where there is no sample; where for too long.
    """
    filled = values.copy()
    cuts = np.flatnonzero(np.diff(lost.astype(np.int8))) + 1
    for rows in np.split(np.arange(len(values)), cuts):
        inside = missing[rows]
        if not lost[rows[0]] and inside.any() and np.count_nonzero(~inside) > AR_ORDER // 8:
            filled[rows] = fill_gaps(values[rows], inside)
    if lost.any():
        known = np.flatnonzero(~missing)
        for column in filled.T:
            column[lost] = np.interp(np.flatnonzero(lost), known, column[known])
    return filled


def mend(values: Real, bad: Mask, missing: Mask, longest: int) -> Mask:
    """Fill short runs of bad values, each channel by itself, like samples that never came.

    Parameters
    ----------
    values : (n_samples, n_channels) array
        Written to.
    bad : (n_samples, n_channels) bool array
        Where values are no measurement.
    missing : (n_samples,) bool array
        Where there is no sample of any channel.
    longest : int
        Samples in a row that are filled.

    Returns
    -------
    (n_samples, n_channels) bool array
        True where a bad value was filled.
    """
    mended = np.zeros_like(bad)
    for column in np.flatnonzero(bad.any(axis=0)):
        holes = bad[:, column] | missing
        long = long_runs(holes, longest)
        if holes.all() or not (holes & ~long).any():
            continue
        unfilled = np.where(holes, np.nan, values[:, column])
        filled = fill_short(unfilled[:, None], holes, long)[:, 0]
        # Of too few neighbours nothing is filled.
        short = holes & ~long & np.isfinite(filled)
        values[short, column] = filled[short]
        mended[:, column] = short & bad[:, column]
    return mended
