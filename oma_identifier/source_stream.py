"""The samples of one source put in order: repeats, late samples and clock jumps sorted out.

Everything is decided sample by sample in order of arrival and on header stamps alone, so it does
not matter how the samples were batched.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from modal_core.measurements import NANOSECONDS_PER_SECOND

REORDER_NS = NANOSECONDS_PER_SECOND
"""Samples this late are still put in place."""
FORWARD_NS = 2 * NANOSECONDS_PER_SECOND
"""A stamp further ahead than this must be confirmed by the next ones."""
CONFIRM = 10
"""Consistent stamps that confirm a jump of the clock."""


@dataclass
class EventCounts:
    """Stamps of what was found, until their window has passed."""

    duplicates: list[int] = field(default_factory=list)
    reordered: list[int] = field(default_factory=list)
    late: list[int] = field(default_factory=list)

    def forget(self, before_ns: int) -> None:
        """Drop events before a time."""
        for events in (self.duplicates, self.reordered, self.late):
            events[:] = [stamp for stamp in events if stamp >= before_ns]


@dataclass(frozen=True, slots=True)
class OrderedSamples:
    """Samples in order of their stamps.

    Parameters
    ----------
    stamp_ns : (n_samples,) int64 array [ns]
        Strictly increasing.
    values : (n_samples, n_channels) array [m/s²]
        As sent.
    """

    stamp_ns: NDArray[np.int64]
    values: NDArray[np.float64]


class SourceStream:
    """Orders the samples of one source.

    Parameters
    ----------
    n_channels : int
        Columns of the samples.

    Attributes
    ----------
    n_pending : int
        Samples held.
    """

    def __init__(self, n_channels: int) -> None:
        self.n_channels = n_channels
        self.events = EventCounts()
        self.first_ns: int | None = None
        self.newest_ns = 0
        self.disordered = False
        self.sealed_ns = -(1 << 62)
        self.jumped: list[OrderedSamples] = []
        self._suspects: list[tuple[int, NDArray[np.float64]]] = []
        self._pending: list[OrderedSamples] = []
        self._sorted = True
        self.n_pending = 0

    def add(self, stamp_ns: NDArray[np.int64], values: NDArray[np.float64]) -> None:
        """Add samples in order of arrival.

        After a confirmed jump backwards the rest goes to ``jumped``.
        """
        if len(stamp_ns) == 0:
            return
        if self.jumped:
            self.jumped.append(OrderedSamples(stamp_ns, values))
            return
        if self.first_ns is None:
            self.first_ns = int(stamp_ns[0])
            self.newest_ns = self.first_ns - 1
        ahead = 0 < int(stamp_ns[0]) - self.newest_ns <= FORWARD_NS
        if not self._suspects and ahead and _is_steady(stamp_ns):
            self._accept(stamp_ns, values)
            return
        self._add_one_by_one(stamp_ns, values)

    def _add_one_by_one(self, stamp_ns: NDArray[np.int64], values: NDArray[np.float64]) -> None:
        accepted: list[int] = []
        for row, stamp in enumerate(stamp_ns.tolist()):
            ahead = stamp - self.newest_ns
            if 0 < ahead <= FORWARD_NS:
                self._drop_suspects()
                self.newest_ns = stamp
                accepted.append(row)
            elif ahead > FORWARD_NS or ahead < -REORDER_NS:
                if self._confirms_jump(stamp, values[row]):
                    self._keep(stamp_ns[accepted], values[accepted])
                    self._jump(stamp_ns[row + 1 :], values[row + 1 :])
                    return
            elif stamp < self.sealed_ns:
                self.events.late.append(stamp)
            else:
                if ahead < 0:
                    self.disordered = True
                    self.events.reordered.append(stamp)
                self._sorted = False
                accepted.append(row)
        self._keep(stamp_ns[accepted], values[accepted])

    def _confirms_jump(self, stamp: int, row: NDArray[np.float64]) -> bool:
        if self._suspects and not 0 < stamp - self._suspects[-1][0] <= FORWARD_NS:
            self._drop_suspects()
        self._suspects.append((stamp, row))
        return len(self._suspects) >= CONFIRM

    def _drop_suspects(self) -> None:
        self.events.late += [stamp for stamp, _ in self._suspects]
        self._suspects = []

    def _jump(self, stamp_ns: NDArray[np.int64], values: NDArray[np.float64]) -> None:
        stamps = np.array([stamp for stamp, _ in self._suspects], dtype=np.int64)
        rows = np.array([row for _, row in self._suspects])
        self._suspects = []
        if stamps[0] > self.newest_ns:
            self._accept(stamps, rows)
            self.add(stamp_ns, values)
        else:
            self.jumped = [OrderedSamples(stamps, rows)]
            if len(stamp_ns):
                self.jumped.append(OrderedSamples(stamp_ns, values))

    def _accept(self, stamp_ns: NDArray[np.int64], values: NDArray[np.float64]) -> None:
        self.newest_ns = int(stamp_ns[-1])
        self._keep(stamp_ns, values)

    def _keep(self, stamp_ns: NDArray[np.int64], values: NDArray[np.float64]) -> None:
        if len(stamp_ns):
            self._pending.append(OrderedSamples(stamp_ns, values))
            self.n_pending += len(stamp_ns)

    def samples(self) -> OrderedSamples:
        """Return all samples held, in order and without repeats."""
        if not self._pending:
            empty = np.empty((0, self.n_channels))
            return OrderedSamples(np.empty(0, dtype=np.int64), empty)
        if len(self._pending) > 1 or not self._sorted:
            stamps = np.concatenate([part.stamp_ns for part in self._pending])
            values = np.concatenate([part.values for part in self._pending])
            if not self._sorted:
                order = np.argsort(stamps, kind='stable')
                stamps, values = stamps[order], values[order]
                repeats = np.flatnonzero(np.diff(stamps) == 0) + 1
                self.events.duplicates += stamps[repeats].tolist()
                stamps, values = np.delete(stamps, repeats), np.delete(values, repeats, axis=0)
                self._sorted = True
            self._pending = [OrderedSamples(stamps, values)]
            self.n_pending = len(stamps)
        return self._pending[0]

    def forget(self, before_ns: int) -> None:
        """Drop samples before a time."""
        held = self.samples()
        first = int(np.searchsorted(held.stamp_ns, before_ns))
        if first:
            # A copy, so that the memory of what was dropped is given back.
            self._pending = [
                OrderedSamples(held.stamp_ns[first:].copy(), held.values[first:].copy())
            ]
            self.n_pending -= first


def _is_steady(stamp_ns: NDArray[np.int64]) -> bool:
    """Tell whether stamps rise, nowhere by more than a jump."""
    steps = stamp_ns[1:] - stamp_ns[:-1]
    if len(steps) == 0:
        return True
    is_short = stamp_ns[-1] - stamp_ns[0] <= FORWARD_NS
    return bool(steps.min() > 0 and (is_short or steps.max() <= FORWARD_NS))
