"""Values that are no new measurements: held, stuffed, interpolated or frozen ones.

A converter that samples anew repeats its last value now and then by chance: where the signal moves
little against the converter's step, and then small changes are as frequent as none.  A value that
is held has no change amid large ones.  Looked at are the samples as sent, before any of them is
interpolated: held values are exactly equal, values stuffed in between are equal to the last but
one, and values between two others on a straight line have no second difference.
"""

from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from oma_identifier.quality.thresholds import QUALITY

BEFORE, TAIL = 16, 96
FEWEST = 8
LOOKED_AT = 160

Real = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class _Part:
    """Counts of a stretch: by kind of difference and channel, no change amid large ones."""

    start_ns: int
    end_ns: int
    n_rows: int
    n_held: NDArray[np.int64]
    n_small: NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class _Run:
    """Rows without change from ``start_ns`` on; ``needed`` of them are a flat line."""

    start_ns: int
    n_rows: int
    needed: float


class RepeatWatch:
    """Watches the samples of one source in order.

    Parameters
    ----------
    n_channels : int
        Columns.
    """

    def __init__(self, n_channels: int) -> None:
        self._step = np.full(n_channels, np.inf)
        self._tail = np.empty((0, n_channels))
        self._tail_ns = np.empty(0, dtype=np.int64)
        self._parts: list[_Part] = []
        self._open: dict[int, _Run] = {}
        self._flat: dict[tuple[int, int], int] = {}

    def add(self, stamp_ns: NDArray[np.int64], values: NDArray[np.floating]) -> None:
        """Look at the next samples, (n_samples, n_channels) array [m/s²], as sent."""
        if len(stamp_ns) == 0:
            return
        held = np.concatenate([self._tail, values])
        times = np.concatenate([self._tail_ns, stamp_ns])
        n_before = len(self._tail)
        with np.errstate(invalid='ignore', over='ignore'):
            self._look(held, times, n_before)
        self._tail, self._tail_ns = held[-TAIL:].copy(), times[-TAIL:].copy()

    def _look(self, held: Real, times: NDArray[np.int64], n_before: int) -> None:
        new = held[max(0, n_before - QUALITY.longest_held - 2) :]
        still = held[1:] == held[:-1]
        n_still = _per_column(still)
        n_held, n_small = np.zeros((2, 3, len(n_still)), dtype=np.int64)
        for column in np.flatnonzero(_is_open(new) | (n_still > QUALITY.held_share * len(still))):
            n_held[:, column], n_small[:, column] = self._counts(int(column), new[:, column])
            if n_still[column] >= QUALITY.flat_at_least:
                self._find_flat(int(column), still[:, column], held[:, column], times)
        first, last = int(times[n_before]), int(times[-1])
        self._parts.append(_Part(first, last, len(times) - n_before, n_held, n_small))
        self._open = {key: run for key, run in self._open.items() if still[-1, key]}

    def _counts(self, column: int, new: Real) -> tuple[list[int], list[int]]:
        """Return the rows of a channel that were held, and those of small changes, by kind."""
        steps, strides = np.diff(new), new[2:] - new[:-2]
        smallest = min(_smallest(steps), _smallest(strides), self._step[column])
        self._step[column] = smallest
        step = smallest if math.isfinite(smallest) else 0.0
        rounding = max(step, QUALITY.float_steps * float(np.nan_to_num(np.abs(new)).max()))
        kinds = (
            _held(steps, 0.0, step),
            _held(strides, 0.0, step),
            _held(np.diff(steps), 0.5 * rounding, rounding),
        )
        return [kind[0] for kind in kinds], [kind[1] for kind in kinds]

    def _find_flat(
        self, column: int, still: NDArray[np.bool_], signal: Real, times: NDArray[np.int64]
    ) -> None:
        edges = np.flatnonzero(np.diff(np.concatenate([[False], still, [False]]).astype(np.int8)))
        for begin, end in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
            if end - begin < QUALITY.flat_at_least:
                continue
            if begin == 0:
                run = self._open.get(column)
            else:
                needed = self._needed(still[:begin], signal[: begin + 1], column)
                run = _Run(int(times[begin]), end - begin, needed)
            if run is None:
                continue
            if end == len(still):
                longer = int(np.count_nonzero(times > self._tail_ns[-1])) if begin == 0 else 0
                run = _Run(run.start_ns, run.n_rows + longer, run.needed)
                self._open[column] = run
            if run.n_rows >= run.needed:
                self._flat[column, run.start_ns] = int(times[end])

    def _needed(self, still: NDArray[np.bool_], signal: Real, column: int) -> float:
        """Return the length from where on a run is no chance, by what came before it."""
        before = signal[-BEFORE:]
        if len(before) < FEWEST or np.ptp(before) < QUALITY.flat_range * self._step[column]:
            return math.inf
        share = (np.count_nonzero(still) + 1.0) / (len(still) + 2.0)
        return max(float(QUALITY.flat_at_least), math.log(QUALITY.flat_chance) / math.log(share))

    def flags(self, start_ns: int, end_ns: int) -> Sequence[tuple[str, ...]]:
        """Return what is wrong with each channel between two times."""
        parts = [p for p in self._parts if p.start_ns < end_ns and p.end_ns >= start_ns]
        n_channels = len(self._step)
        if not parts:
            return [()] * n_channels
        n_held = np.sum([part.n_held for part in parts], axis=0)
        n_small = np.sum([part.n_small for part in parts], axis=0)
        least = max(QUALITY.held_at_least, QUALITY.held_share * sum(part.n_rows for part in parts))
        is_held = ((n_held > least) & (n_held > n_small)).any(axis=0)
        is_flat = np.zeros(n_channels, dtype=bool)
        for (column, begin), end in self._flat.items():
            is_flat[column] |= begin < end_ns and end >= start_ns
        return [
            (*(['sample_and_hold'] if held else []), *(['flatline'] if flat else []))
            for held, flat in zip(is_held, is_flat, strict=True)
        ]

    def forget(self, before_ns: int) -> None:
        """Drop what was found before a time."""
        self._parts = [part for part in self._parts if part.end_ns >= before_ns]
        self._flat = {key: end for key, end in self._flat.items() if end >= before_ns}

    def restart(self, first_ns: int) -> None:
        """Go on at an earlier time, to which nothing found at a later one belongs."""
        self._tail, self._tail_ns = self._tail[:0], self._tail_ns[:0]
        self._parts = [part for part in self._parts if part.end_ns < first_ns]
        self._flat = {key: end for key, end in self._flat.items() if end < first_ns}
        self._open = {}


def _per_column(true: NDArray[np.bool_]) -> NDArray[np.int64]:
    n_columns = true.shape[1]
    return np.bincount(np.flatnonzero(true) % n_columns, minlength=n_columns)


def _is_open(rows: Real) -> NDArray[np.bool_]:
    """Tell which channels need a closer look, by the first rows of a stretch."""
    rows = rows[:LOOKED_AT]
    strides, bends = rows[2:] - rows[:-2], rows[2:] - 2.0 * rows[1:-1] + rows[:-2]
    rounding = 0.5 * QUALITY.float_steps * np.abs(rows).max(axis=0)
    return np.asarray(
        np.count_nonzero((strides == 0.0) | (np.abs(bends) <= rounding), axis=0)
        > QUALITY.held_share * len(rows)
    )


def _smallest(changes: Real) -> float:
    """Return the smallest change that is one."""
    size = np.abs(changes)
    return float(np.min(size[size > 0.0], initial=np.inf))


def _held(changes: Real, none: float, step: float) -> tuple[int, int]:
    """Return the rows without change between large ones, and the rows of small changes."""
    size = np.abs(changes)
    place = np.flatnonzero(~(size <= none))
    large = size[place] > QUALITY.large_change * step
    between = np.diff(place) - 1
    held = large[1:] & large[:-1] & (between <= QUALITY.longest_held)
    return int(between[held].sum()), int(np.count_nonzero(~large))
