"""Values far outside of all others: what recorders write for samples they lost, and sparks.

What vibrates passes through every value between its middle and its largest, and what is struck
rings down through them.  A value beyond an empty band of several times all that others reach is no
measurement: a placeholder (9999, -999, full scale), which comes again as exactly the same, or a
spark, which comes alone and is not answered: what is struck rings.
"""

from collections import Counter
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from oma_identifier.time_axis.gaps import Mask
from oma_identifier.time_axis.thresholds import TIME_AXIS

LOOKED_AT = 128
"""Rows that tell where the middle of a channel is: the median of so many Gaussian ones scatters by
0.11 of their deviation."""

MOST_SEEN = 256
"""Values that are remembered in case they come again, and of a channel that came again.  Bounds
memory: of a recorder there are one or two."""

Real = NDArray[np.floating]
FarValue = tuple[int, float, int]
# Start of a stretch [ns], a value in it [m/s²], how many samples have it.


@dataclass(frozen=True, slots=True)
class _Found:
    """Samples of a channel with one far value, new in a stretch."""

    start_ns: int
    channel: int
    value: float
    n_samples: int


class FarValues:
    """Finds far values among the samples of one source, stretch after stretch.

    Parameters
    ----------
    n_channels : int
        Columns.
    """

    def __init__(self, n_channels: int) -> None:
        self._middle = np.full(n_channels, np.nan)
        self._largest = np.zeros(n_channels)
        self._known: dict[int, dict[float, None]] = {}
        self._seen: dict[tuple[int, float], int] = {}
        self._found: list[_Found] = []

    def mark(self, stamp_ns: NDArray[np.int64], values: Real, start_ns: int, end_ns: int) -> Mask:
        """Return which values are far outside of all others, (n_samples, n_channels) array.

        Parameters
        ----------
        stamp_ns : (n_samples,) array [ns]
            Of a stretch, and of what lies about it.
        values : (n_samples, n_channels) array [m/s²]
            The samples.
        start_ns, end_ns : int [ns]
            Of the stretch: what was found in it is told.
        """
        if len(values) < TIME_AXIS.fewest_values:
            return np.zeros(values.shape, dtype=bool)
        with np.errstate(invalid='ignore', over='ignore'):
            return self._marked(stamp_ns, values, start_ns, end_ns)

    def _marked(
        self, stamp_ns: NDArray[np.int64], values: Real, start_ns: int, end_ns: int
    ) -> Mask:
        far = np.zeros(values.shape, dtype=bool)
        some = values[:: max(1, len(values) // LOOKED_AT)]
        middle = np.median(some, axis=0)
        reach = np.maximum(values.max(axis=0) - middle, middle - values.min(axis=0))
        usual = np.median(np.abs(some - middle), axis=0)
        # False for NaN.
        suspect = ~(reach <= TIME_AXIS.suspect_reach * usual)
        remembered = TIME_AXIS.remembered * self._largest
        for channel in sorted({*np.flatnonzero(suspect).tolist(), *self._known}):
            signal = values[:, channel].astype(np.float64)
            far[:, channel], ordinary = self._far(channel, signal, values, stamp_ns)
            middle[channel], reach[channel] = self._ordinary(channel, signal[ordinary])
        self._middle, self._largest = middle, np.maximum(remembered, reach)
        inside = (stamp_ns >= start_ns) & (stamp_ns < end_ns)
        for channel in np.flatnonzero(far.any(axis=0)).tolist():
            new = values[far[:, channel] & inside, channel].tolist()
            self._found += [_Found(start_ns, channel, x, n) for x, n in Counter(new).items()]
        return far

    def _ordinary(self, channel: int, signal: NDArray[np.float64]) -> tuple[float, float]:
        """Return the middle of a channel without what is far, and the farthest from it."""
        before = float(self._middle[channel]), float(self._largest[channel])
        if len(signal) < TIME_AXIS.fewest_values:
            return before
        middle = float(np.median(signal))
        if 2 * np.count_nonzero(signal == middle) > len(signal):
            return before  # One value, most of the time, may stand for samples lost.
        return middle, float(np.abs(signal - middle).max())

    def _far(
        self,
        channel: int,
        signal: NDArray[np.float64],
        values: Real,
        stamp_ns: NDArray[np.int64],
    ) -> tuple[Mask, Mask]:
        """Return which samples are no measurements, and which are ordinary."""
        known = np.isin(signal, list(self._known.get(channel, ())))
        rest = ~known & (np.abs(signal) <= TIME_AXIS.largest_value)
        if np.count_nonzero(rest) < TIME_AXIS.fewest_values:
            return known, rest
        largest, middle = float(self._largest[channel]), float(self._middle[channel])
        half = 0
        if not largest > 0.0:
            # Nothing is known of the channel: what most samples are is ordinary.
            middle, half = float(np.median(signal[rest])), int(np.count_nonzero(rest)) // 2
        away = np.abs(signal - middle)
        known &= away > largest
        ordered = np.sort(away[rest])[half:]
        empty = np.flatnonzero(
            ordered[1:] > TIME_AXIS.far_again * np.maximum(ordered[:-1], largest)
        )
        if not len(empty):
            return known, rest
        limit = max(float(ordered[empty[0]]), largest)
        ordinary = rest & (away <= limit)
        if len(np.unique(signal[ordinary])) < TIME_AXIS.fewest_values:
            return known, rest
        beyond = rest & ~ordinary
        again = self._again(channel, signal, beyond, limit, stamp_ns)
        alone = beyond & (away > TIME_AXIS.far_alone * limit) & _single(beyond)
        for row in np.flatnonzero(alone).tolist():
            alone[row] = not _is_answered(values, row)
        return known | alone | np.isin(signal, again), ordinary

    def _again(
        self,
        channel: int,
        signal: NDArray[np.float64],
        beyond: Mask,
        limit: float,
        stamp_ns: NDArray[np.int64],
    ) -> list[float]:
        """Return values that recur exactly, none other near them in value, nor beside them."""
        found = np.unique(signal[beyond])
        apart = np.diff(found, prepend=-np.inf, append=np.inf) > limit
        again = []
        for value in found[apart[:-1] & apart[1:]].tolist():
            rows = np.flatnonzero(signal == value)
            beside = np.concatenate([rows[rows > 0] - 1, rows[rows < len(signal) - 1] + 1])
            if np.any(beyond[beside] & (signal[beside] != value)):
                continue  # What begins suddenly goes on with other values.
            seen_ns = self._seen.setdefault((channel, value), int(stamp_ns[rows[0]]))
            if len(rows) > 1 or seen_ns != stamp_ns[rows[0]]:
                again.append(value)
        if again:
            self._known.setdefault(channel, {}).update(dict.fromkeys(again))
        for kept in (self._seen, self._known.get(channel, {})):
            _forget_oldest(kept)
        return again

    def told(self, start_ns: int, end_ns: int) -> list[tuple[FarValue, ...]]:
        """Return what was found in a window, one per channel."""
        told: list[list[FarValue]] = [[] for _ in self._middle]
        for each in self._found:
            if start_ns <= each.start_ns < end_ns:
                told[each.channel].append((each.start_ns, each.value, each.n_samples))
        return [tuple(of_channel) for of_channel in told]

    def forget(self, before_ns: int) -> None:
        """Drop what was found before a time."""
        self._found = [each for each in self._found if each.start_ns >= before_ns]


def _forget_oldest(kept: dict[Any, Any]) -> None:
    while len(kept) > MOST_SEEN:
        del kept[next(iter(kept))]


def _single(beyond: Mask) -> Mask:
    """Return where one sample alone is beyond, with ordinary ones to both sides."""
    count = np.convolve(beyond, np.ones(2 * TIME_AXIS.rest_beside + 1, dtype=np.int64), 'same')
    single = beyond & (count == 1)
    single[: TIME_AXIS.rest_beside] = single[len(single) - TIME_AXIS.rest_beside :] = False
    return np.asarray(single)


def _is_answered(values: Real, row: int) -> bool:
    """Tell whether a channel moves more behind a row than before: what was struck rings."""
    before = values[max(0, row - TIME_AXIS.answer) : row]
    after = values[row + 1 : row + 1 + TIME_AXIS.answer]
    middle = np.median(before, axis=0)
    grown = np.abs(after - middle).max(axis=0) > TIME_AXIS.grown * np.abs(before - middle).max(
        axis=0
    )
    return bool(grown.any())
