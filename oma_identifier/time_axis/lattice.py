"""A stretch of one source as a lattice of equal steps, gaps filled and jitter removed."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from oma_identifier.time_axis.gaps import (
    fill_short,
    long_runs,
    longest_filled,
    mend,
    no_measurement,
)
from oma_identifier.time_axis.resample import half_width, interpolate, remove_jitter
from oma_identifier.time_axis.source_stream import OrderedSamples
from oma_identifier.time_axis.thresholds import TIME_AXIS


@dataclass(frozen=True, slots=True)
class Lattice:
    """Equally spaced samples of one source.

    Parameters
    ----------
    origin_ns : float [ns]
        Time of the first sample, from the reference time given.
    period_ns : float [ns]
        Step.
    values : (n_samples, n_channels) array [m/s²]
        Finite everywhere.
    lost : (n_samples,) bool array
        True in gaps too long to fill.
    filled : (n_samples,) bool array
        True where a short gap was filled.
    bad : (n_samples, n_channels) bool array
        True where the source sent what is no number, for too long to fill.
    mended : (n_samples, n_channels) bool array
        True where it did for a short while, which was filled.
    jitter_std_s : float [s]
        Scatter of the stamps about the lattice.
    uniform : bool
        The samples were taken as they are.
    """

    origin_ns: float
    period_ns: float
    values: NDArray[np.float64]
    lost: NDArray[np.bool_]
    filled: NDArray[np.bool_]
    bad: NDArray[np.bool_]
    mended: NDArray[np.bool_]
    jitter_std_s: float
    uniform: bool


@dataclass(frozen=True, slots=True)
class GridRows:
    """A lattice on the common grid.

    Parameters
    ----------
    values : (n_rows, n_channels) array [m/s²]
        Zero where lost.
    lost, filled : (n_rows,) bool array
        As in :class:`Lattice`.
    bad, mended : (n_rows, n_channels) bool array
        As in :class:`Lattice`.
    """

    values: NDArray[np.float64]
    lost: NDArray[np.bool_]
    filled: NDArray[np.bool_]
    bad: NDArray[np.bool_]
    mended: NDArray[np.bool_]

    @classmethod
    def nothing(cls, n_rows: int, n_channels: int) -> 'GridRows':
        """Return rows of a source that has no samples for them."""
        return cls(
            values=np.zeros((n_rows, n_channels)),
            lost=np.ones(n_rows, dtype=bool),
            filled=np.zeros(n_rows, dtype=bool),
            bad=np.zeros((n_rows, n_channels), dtype=bool),
            mended=np.zeros((n_rows, n_channels), dtype=bool),
        )


def margin_ns(period_ns: float, cutoff: float) -> int:
    """Return the time a lattice must reach past the grid to either side [ns]."""
    return int((half_width(cutoff) + 2) * period_ns)


def make_lattice(
    samples: OrderedSamples,
    reference_ns: int,
    period_ns: float,
    *,
    uniform: bool,
    tick_ns: int = 0,
) -> Lattice | None:
    """Place samples on a lattice.

    Parameters
    ----------
    samples : OrderedSamples
        Of one source.
    reference_ns : int [ns]
        Time that ``origin_ns`` counts from.
    period_ns : float [ns]
        Step to expect.
    uniform : bool
        The source counts its samples: stamps are exact.
    tick_ns : int [ns]
        Stamps are whole multiples of it.

    Returns
    -------
    Lattice or None
        None when there are too few samples to tell.
    """
    if len(samples.stamp_ns) < 4:
        return None
    time_ns = (samples.stamp_ns - reference_ns).astype(np.float64)
    place = np.concatenate([[0.0], np.cumsum(np.rint(np.diff(time_ns) / period_ns))])
    if place[-1] < 3:
        return None
    # Two samples of one place: the stamps scatter more than a step.
    if np.any(np.diff(place) < 1.0):
        place = np.arange(len(place), dtype=np.float64)
    slope, start = _line(place, time_ns)
    offsets = (time_ns - start) / slope - place
    jitter = float(np.std(offsets))
    if place[-1] > TIME_AXIS.most_places + TIME_AXIS.sparsest * len(place):
        return None
    n_places = int(place[-1]) + 1
    values = np.asarray(samples.values, dtype=np.float64)
    bad = no_measurement(values)
    if bad.any():
        values = np.where(bad, 0.0, values)
    missing = np.zeros(n_places, dtype=bool)
    lost = missing
    row = place.astype(np.int64)
    if n_places > len(row):
        missing[:] = True
        missing[row] = False
        lost = long_runs(missing, longest_filled(slope))
        values, bad = (_in_place(each, row, n_places) for each in (values, bad))
    # Stamps that spread over no more than their tick are those of even samples.
    even = np.ptp(offsets) * slope <= TIME_AXIS.tick_reach * tick_ns
    as_is = (
        uniform
        or even
        or jitter < TIME_AXIS.smallest_jitter
        or np.abs(offsets).max() > TIME_AXIS.largest_jitter
    )
    if missing.any():
        values = fill_short(values, missing, lost)
    mended = mend(values, bad, missing, longest_filled(slope))
    if not as_is:
        beside = np.zeros(n_places)
        beside[row] = offsets
        values = remove_jitter(values, beside)
    return Lattice(
        origin_ns=start,
        period_ns=slope,
        values=values,
        lost=lost,
        filled=missing & ~lost,
        bad=bad & ~mended,
        mended=mended,
        jitter_std_s=jitter * slope * 1e-9,
        uniform=as_is,
    )


def on_grid(lattice: Lattice, grid_ns: NDArray[np.float64], cutoff: float) -> GridRows:
    """Evaluate a lattice at the times of the common grid.

    Parameters
    ----------
    lattice : Lattice
        One source.
    grid_ns : (n_rows,) array [ns]
        From the same reference time as the lattice.
    cutoff : float
        Rate of the grid over the rate of the lattice, at most 1.
    """
    position = (grid_ns - lattice.origin_ns) / lattice.period_ns
    nearest = np.rint(position).astype(np.int64)
    last = len(lattice.values) - 1
    inside = np.clip(nearest, 0, last)
    lost = lattice.lost[inside] | (position < -1.0) | (position > last + 1.0)
    if (
        cutoff >= 1.0
        and lattice.uniform
        and np.abs(position - nearest).max() < TIME_AXIS.same_place
    ):
        if (inside[1:] - inside[:-1] == 1).all() and not lost.any():
            rows = slice(inside[0], inside[-1] + 1)
            masks = (x[rows] for x in (lattice.filled, lattice.bad, lattice.mended))
            return GridRows(lattice.values[rows], lost, *masks)
        values = lattice.values[inside]
    else:
        values = interpolate(lattice.values, np.clip(position, -1.0, last + 1.0), cutoff)
    values[lost] = 0.0
    masks = (x[inside] for x in (lattice.filled, lattice.bad, lattice.mended))
    return GridRows(values, lost, *masks)


def _in_place(rows: NDArray[np.generic], places: NDArray[np.int64], n_places: int) -> NDArray[Any]:
    """Return rows at their places, zeros elsewhere."""
    placed = np.zeros((n_places, rows.shape[1]), rows.dtype)
    placed[places] = rows
    return placed


def _line(place: NDArray[np.float64], time_ns: NDArray[np.float64]) -> tuple[float, float]:
    middle = place.mean()
    centred = place - middle
    slope = float(centred @ time_ns / (centred @ centred))
    return slope, float(time_ns.mean() - slope * middle)
