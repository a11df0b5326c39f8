"""Faults that show only in how samples follow one another, looked for as the samples come."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from oma_identifier.quality.converter import is_one_sided, is_rectified, is_wrapped, leaps
from oma_identifier.quality.reversed_rows import is_reversed
from oma_identifier.quality.thresholds import QUALITY

CHUNK = 2048
"""Rows that are looked at together."""

RECTIFIED = 'rectified'
Flags = tuple[str, ...]


@dataclass(frozen=True, slots=True)
class _Part:
    """What was found in a stretch, one per channel."""

    start_ns: int
    end_ns: int
    found: Sequence[Flags]
    both_signs: NDArray[np.bool_]


class ConverterWatch:
    """Watches the samples of one source in order.

    Parameters
    ----------
    n_channels : int
        Columns.
    """

    def __init__(self, n_channels: int) -> None:
        self._rows = np.empty((CHUNK, n_channels))
        self._times = np.empty(CHUNK, dtype=np.int64)
        self._n_held = 0
        self._parts: list[_Part] = []
        self._newest: _Part | None = None

    def add(self, stamp_ns: NDArray[np.int64], values: NDArray[np.floating]) -> None:
        """Look at the next samples, (n_samples, n_channels) array [m/s²], as sent."""
        while len(stamp_ns):
            n_taken = min(CHUNK - self._n_held, len(stamp_ns))
            here = slice(self._n_held, self._n_held + n_taken)
            self._rows[here], self._times[here] = values[:n_taken], stamp_ns[:n_taken]
            stamp_ns, values = stamp_ns[n_taken:], values[n_taken:]
            self._n_held += n_taken
            self._newest = None
            if self._n_held == CHUNK:
                self._parts.append(self._examined())
                self._n_held = 0

    def _examined(self) -> _Part:
        times = self._times[: self._n_held]
        rows = self._rows[: self._n_held]
        pieces = _unbroken(times, rows)
        found = [found_in(piece) for piece in pieces if len(piece) >= QUALITY.fewest_rows]
        return _Part(
            int(times[0]),
            int(times[-1]),
            [
                tuple(dict.fromkeys(flag for each in found for flag in each[column]))
                for column in range(self._rows.shape[1])
            ],
            np.asarray((rows < 0.0).any(axis=0) & (rows > 0.0).any(axis=0)),
        )

    def flags(self, start_ns: int, end_ns: int) -> Sequence[Flags]:
        """Return what is wrong with each channel between two times.

        One that has values of both signs there has a sign, whatever a stretch of it looks like:
        few swings beside an offset may well end at zero.
        """
        if self._n_held >= QUALITY.fewest_rows and self._newest is None:
            self._newest = self._examined()
        parts = [*self._parts, *([self._newest] if self._newest else [])]
        inside = [part for part in parts if part.start_ns < end_ns and part.end_ns >= start_ns]
        has_sign = [False] * self._rows.shape[1]
        if inside:
            has_sign = np.any([part.both_signs for part in inside], axis=0).tolist()
        return [
            tuple(
                flag
                for flag in dict.fromkeys(f for part in inside for f in part.found[column])
                if not (flag == RECTIFIED and has_sign[column])
            )
            for column in range(self._rows.shape[1])
        ]

    def forget(self, before_ns: int) -> None:
        """Drop what was found before a time."""
        self._parts = [part for part in self._parts if part.end_ns >= before_ns]

    def restart(self, first_ns: int) -> None:
        """Go on at an earlier time, to which nothing found at a later one belongs."""
        self._n_held, self._newest = 0, None
        self._parts = [part for part in self._parts if part.end_ns < first_ns]


def _unbroken(stamp_ns: NDArray[np.int64], rows: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """Return the pieces between lost samples: what follows a gap leaps without any fault."""
    steps = np.diff(stamp_ns)
    return np.split(rows, np.flatnonzero(steps > QUALITY.lost_step * np.median(steps)) + 1)


def found_in(rows: NDArray[np.float64]) -> list[Flags]:
    """Return what is wrong with each channel of a stretch, (n_samples, n_channels) array."""
    signals = np.ascontiguousarray(rows.T)
    with np.errstate(invalid='ignore', over='ignore'):
        low, high = signals.min(axis=1), signals.max(axis=1)
        usable = (
            (-QUALITY.largest_value < low)
            & (high < QUALITY.largest_value)
            & (high - low > QUALITY.smallest_range)
        )
        tests = (
            ('wrapped', is_wrapped, usable & leaps(signals)),
            (RECTIFIED, is_rectified, usable & is_one_sided(signals)),
        )
    turned: Flags = ('rows_reversed',) if is_reversed(signals[usable]) else ()
    found = [turned] * len(signals)
    for name, test, suspects in tests:
        for channel in np.flatnonzero(suspects):
            if test(signals[channel]):
                found[channel] = (*found[channel], name)
    return found
