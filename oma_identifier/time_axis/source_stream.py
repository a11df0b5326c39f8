"""The samples of one source put in order: repeats, late samples and clock jumps sorted out.

Everything is decided sample by sample in order of arrival and on header stamps alone, so it does
not matter how the samples were batched.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from oma_identifier.time_axis.candidates import Candidates
from oma_identifier.time_axis.thresholds import TIME_AXIS

DOUBLE: 'np.dtype[np.floating]' = np.dtype(np.float64)
SINGLY_AT_FIRST = 1024
"""Samples looked at one by one before the rest is looked at as a whole again."""


@dataclass
class EventCounts:
    """Stamps of what was found, until their window has passed."""

    duplicates: list[int] = field(default_factory=list)
    reordered: list[int] = field(default_factory=list)
    late: list[int] = field(default_factory=list)

    @property
    def n_held(self) -> int:
        """Events held."""
        return len(self.duplicates) + len(self.reordered) + len(self.late)

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
    values: NDArray[np.floating]


@dataclass(frozen=True, slots=True)
class _Sample:
    stamp_ns: int
    row: NDArray[np.floating]


class SourceStream:
    """Orders the samples of one source.

    Parameters
    ----------
    n_channels : int
        Columns of the samples.
    set_aside : Counter or None
        Where samples are counted whose stamps others do not confirm.
    dtype : numpy dtype
        Precision of the samples.

    Attributes
    ----------
    first_ns : int or None [ns]
        Where the stamps began, or went on after the clock jumped.
    n_pending : int
        Samples held.
    """

    def __init__(
        self,
        n_channels: int,
        set_aside: 'Counter[str] | None' = None,
        dtype: 'np.dtype[np.floating]' = DOUBLE,
    ) -> None:
        self.n_channels = n_channels
        self.dtype = dtype
        self.events = EventCounts()
        self.set_aside: Counter[str] = Counter() if set_aside is None else set_aside
        self.first_ns: int | None = None
        self.newest_ns = 0
        self.disordered = False
        self.sealed_ns = -(1 << 62)
        self.jumped: list[OrderedSamples] = []
        self._suspects: Candidates[_Sample] = Candidates(_is_near, _size, self._drop)
        self._behind: list[_Sample] = []
        self._pending: list[OrderedSamples] = []
        self._sorted = True
        self.n_pending = 0

    @property
    def is_waiting(self) -> bool:
        """Whether there are samples, but none whose stamp is confirmed."""
        return self.first_ns is None and len(self._suspects) > 0

    def add(
        self, stamp_ns: NDArray[np.int64], values: NDArray[np.floating], *, confirmed: bool = False
    ) -> None:
        """Add samples in order of arrival.

        After a confirmed jump backwards the rest goes to ``jumped``.

        Parameters
        ----------
        stamp_ns : (n_samples,) int64 array [ns]
            Their stamps.
        values : (n_samples, n_channels) array [m/s²]
            The samples.
        confirmed : bool
            Others agree with these stamps already.
        """
        n_taken = 0
        while n_taken < len(stamp_ns):
            n_taken += self._take(stamp_ns[n_taken:], values[n_taken:], confirmed=confirmed)
            confirmed = False

    def _take(
        self, stamp_ns: NDArray[np.int64], values: NDArray[np.floating], *, confirmed: bool
    ) -> int:
        """Take in the first of some samples; returns how many of them."""
        if self.jumped:
            self.jumped.append(OrderedSamples(stamp_ns, values))
            return len(stamp_ns)
        ahead, begun = int(stamp_ns[0]) - self.newest_ns, self.first_ns is not None
        open_ended = self._suspects or self._behind
        goes_on = begun and not open_ended and 0 < ahead <= TIME_AXIS.forward_ns
        if confirmed and (not begun or ahead > TIME_AXIS.forward_ns):
            self._begin(stamp_ns, values)
        elif confirmed and ahead < -TIME_AXIS.reorder_ns:
            self.jumped = [OrderedSamples(stamp_ns, values)]
        elif goes_on and _is_steady(stamp_ns):
            self._accept(stamp_ns, values)
        else:
            return self._take_one_by_one(stamp_ns[:SINGLY_AT_FIRST], values[:SINGLY_AT_FIRST])
        return len(stamp_ns)

    def _begin(self, stamp_ns: NDArray[np.int64], values: NDArray[np.floating]) -> None:
        """Begin, or go on after a jump forwards."""
        self.first_ns = int(stamp_ns[0])
        self.newest_ns = self.first_ns - 1
        self.add(stamp_ns, values)

    def _take_one_by_one(self, stamp_ns: NDArray[np.int64], values: NDArray[np.floating]) -> int:
        accepted: list[int] = []
        for row, stamp in enumerate(stamp_ns.tolist()):
            ahead = stamp - self.newest_ns
            if self._behind:
                sample = _Sample(stamp, values[row].copy())
                if self._behind[-1].stamp_ns < stamp <= self.newest_ns:
                    self._behind.append(sample)
                    continue
                self._keep(stamp_ns[accepted], values[accepted])
                if self._was_set_back(stamp):
                    self.jumped = [_together([*self._behind, sample])]
                    self._behind = []
                    return row + 1
                self._put_in_place()
                accepted = []
            if self.first_ns is None or not -TIME_AXIS.reorder_ns <= ahead <= TIME_AXIS.forward_ns:
                run = self._suspects.add(_Sample(stamp, values[row].copy()))
                if run.n_items >= TIME_AXIS.confirm:
                    self._keep(stamp_ns[accepted], values[accepted])
                    self._jump(self._suspects.take(run))
                    return row + 1
            elif ahead > 0:
                self._suspects.clear()
                self.newest_ns = stamp
                accepted.append(row)
            elif ahead < 0:
                self.disordered = True
                self._behind.append(_Sample(stamp, values[row].copy()))
            elif stamp < self.sealed_ns:
                self.events.late.append(stamp)
            else:
                self._sorted = False
                accepted.append(row)
        self._keep(stamp_ns[accepted], values[accepted])
        return len(stamp_ns)

    def _was_set_back(self, next_ns: int) -> bool:
        """Tell whether the samples that stay behind do because the clock was set back.

        Then they go on without a leap until they catch up, over times that have samples already.
        Late messages fill a hole, and the stamps leap forward behind them.
        """
        run = _together(self._behind)
        if len(run.stamp_ns) < TIME_AXIS.confirm or next_ns <= self.newest_ns:
            return False
        steps = np.diff(run.stamp_ns, append=next_ns)
        held = self.samples()
        if steps[-1] > 2 * np.median(steps) or not len(held.stamp_ns):
            return False
        seen = run.stamp_ns >= held.stamp_ns[0]
        there = held.stamp_ns[np.searchsorted(held.stamp_ns, run.stamp_ns[0]) :]
        places = np.minimum(np.searchsorted(held.stamp_ns, run.stamp_ns), len(held.stamp_ns) - 1)
        again = (held.values[places] == run.values).all(axis=1)
        return bool(2 * len(there) > seen.sum() > 0 and 2 * again.sum() < len(again))

    def _put_in_place(self) -> None:
        """Take in the samples that came late."""
        late, self._behind = self._behind, []
        self.events.late += [each.stamp_ns for each in late if each.stamp_ns < self.sealed_ns]
        kept = [each for each in late if each.stamp_ns >= self.sealed_ns]
        if kept:
            self.events.reordered += [each.stamp_ns for each in kept]
            self._sorted = False
            samples = _together(kept)
            self._keep(samples.stamp_ns, samples.values)

    def _jump(self, confirmed: Sequence[_Sample]) -> None:
        """Go on with samples that confirm one another."""
        samples = _together(confirmed)
        self._suspects.clear()
        self.add(samples.stamp_ns, samples.values, confirmed=True)

    def _drop(self, samples: Sequence[_Sample]) -> None:
        self.set_aside['stamp_unconfirmed'] += len(samples)

    def flush(self, *, alone: bool) -> None:
        """Go on with what is there at the end of a record too short to confirm anything.

        Parameters
        ----------
        alone : bool
            No other source has a time that it would have to agree with.
        """
        self._put_in_place()
        run = self._suspects.longest()
        if alone and self.first_ns is None and run is not None:
            self._jump(self._suspects.take(run))
        self._suspects.clear()

    def expire(self) -> None:
        """Drop samples that have waited in vain to be confirmed."""
        self._suspects.expire()

    def _accept(self, stamp_ns: NDArray[np.int64], values: NDArray[np.floating]) -> None:
        self.newest_ns = int(stamp_ns[-1])
        self._keep(stamp_ns, values)

    def _keep(self, stamp_ns: NDArray[np.int64], values: NDArray[np.floating]) -> None:
        if len(stamp_ns):
            self._pending.append(OrderedSamples(stamp_ns, values))
            self.n_pending += len(stamp_ns)

    def samples(self) -> OrderedSamples:
        """Return all samples held, in order and without repeats."""
        if not self._pending:
            empty = np.empty((0, self.n_channels), self.dtype)
            return OrderedSamples(np.empty(0, dtype=np.int64), empty)
        if len(self._pending) > 1 or not self._sorted:
            stamps = np.concatenate([part.stamp_ns for part in self._pending])
            values = np.concatenate([part.values for part in self._pending])
            if not self._sorted:
                order = np.argsort(stamps, kind='stable')
                stamps, values = stamps[order], values[order]
                repeats = _repeats(stamps, values)
                self.events.duplicates += stamps[repeats].tolist()
                stamps, values = np.delete(stamps, repeats), np.delete(values, repeats, axis=0)
                self._sorted = True
            self._pending = [OrderedSamples(stamps, values)]
            self.n_pending = len(stamps)
        return self._pending[0]

    @property
    def n_bytes(self) -> int:
        """Memory that waiting samples and events take, about."""
        later = sum(part.values.nbytes for part in self.jumped)
        later += sum(map(_size, self._behind))
        held = self.dtype.itemsize * self.n_channels * self.n_pending
        return held + later + 40 * self.events.n_held

    def drop(self) -> None:
        """Give up all that waits."""
        self._pending, self.n_pending, self._sorted = [], 0, True
        self._behind = []
        self.jumped = []
        self.events = EventCounts()

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


def _together(samples: Sequence[_Sample]) -> OrderedSamples:
    return OrderedSamples(
        np.array([sample.stamp_ns for sample in samples], dtype=np.int64),
        np.array([sample.row for sample in samples]),
    )


def _is_near(last: _Sample, sample: _Sample) -> bool:
    return -TIME_AXIS.reorder_ns <= sample.stamp_ns - last.stamp_ns <= TIME_AXIS.forward_ns


def _size(sample: _Sample) -> int:
    return sample.row.nbytes


def _repeats(stamp_ns: NDArray[np.int64], values: NDArray[np.floating]) -> NDArray[np.int64]:
    """Return the rows that came before, stamp and values; a stamp alone may serve for several."""
    repeats = []
    shared = np.flatnonzero(np.diff(stamp_ns) == 0) + 1
    for group in np.split(shared, np.flatnonzero(np.diff(shared) > 1) + 1):
        if len(group):
            seen = {values[group[0] - 1].tobytes()}
            for row in group.tolist():
                sent = values[row].tobytes()
                if sent in seen:
                    repeats.append(row)
                seen.add(sent)
    return np.array(repeats, dtype=np.int64)


def _is_steady(stamp_ns: NDArray[np.int64]) -> bool:
    """Tell whether stamps rise, nowhere by more than a jump."""
    steps = stamp_ns[1:] - stamp_ns[:-1]
    if len(steps) == 0:
        return True
    is_short = stamp_ns[-1] - stamp_ns[0] <= TIME_AXIS.forward_ns
    return bool(steps.min() > 0 and (is_short or steps.max() <= TIME_AXIS.forward_ns))
