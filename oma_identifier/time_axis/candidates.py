"""Messages that nothing confirms yet, kept in runs until one run is long enough to be believed.

A stamp, a rate or a set of names counts when several messages in a row agree on it.  Messages
that agree with each other make a run; false ones make runs that never grow.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Generic, TypeVar

from oma_identifier.time_axis.thresholds import TIME_AXIS

T = TypeVar('T')


@dataclass
class Run(Generic[T]):
    """Messages that follow one another.

    Parameters
    ----------
    first : T
        The first of them, held or not.
    held : list
        The newest of them.
    n_items : int
        How many there were.
    n_bytes : int
        Size of those held.
    grown : bool
        Since the last look at what has expired.
    """

    first: T
    held: list[T] = field(default_factory=list)
    n_items: int = 0
    n_bytes: int = 0
    grown: bool = True


class Candidates(Generic[T]):
    """Runs of messages that wait to be confirmed, in bounded memory.

    Parameters
    ----------
    follows : callable
        Tells whether a message (second) continues a run that ends with another (first).
    size : callable
        Bytes of a message.
    set_aside : callable
        Told the messages that were dropped.
    """

    def __init__(
        self,
        follows: Callable[[T, T], bool],
        size: Callable[[T], int],
        set_aside: Callable[[Sequence[T]], None],
    ) -> None:
        self._follows = follows
        self._size = size
        self._set_aside = set_aside
        self._runs: list[Run[T]] = []

    def __len__(self) -> int:
        return len(self._runs)

    def add(self, item: T) -> Run[T]:
        """Put a message to the run it continues, else begin one; returns the run."""
        run = next((run for run in self._runs if self._follows(run.held[-1], item)), None)
        if run is None:
            run = Run(item)
            self._runs.append(run)
            if len(self._runs) > TIME_AXIS.most_runs:
                self._drop(self._runs[0])
        run.held.append(item)
        run.n_items += 1
        run.n_bytes += self._size(item)
        run.grown = True
        self._bound(run)
        return run

    def _bound(self, newest: Run[T]) -> None:
        while (
            len(self._runs) > 1
            and sum(run.n_bytes for run in self._runs) > TIME_AXIS.most_waiting_bytes
        ):
            self._drop(next(run for run in self._runs if run is not newest))
        while newest.n_bytes > TIME_AXIS.most_waiting_bytes and len(newest.held) > 1:
            oldest = newest.held.pop(0)
            newest.n_bytes -= self._size(oldest)
            self._set_aside([oldest])

    def _drop(self, run: Run[T]) -> None:
        self._runs.remove(run)
        self._set_aside(run.held)

    def take(self, run: Run[T]) -> list[T]:
        """Return the messages of a run that is confirmed, and keep them no longer."""
        self._runs.remove(run)
        return run.held

    def in_order(self) -> list[T]:
        """Return what waits in order of arrival; nothing where runs may be interleaved."""
        if len(self._runs) == 1 or all(run.n_items == 1 for run in self._runs):
            return [item for run in self._runs for item in run.held]
        return []

    def longest(self) -> Run[T] | None:
        """Return the run with most messages, of equals the first."""
        return max(self._runs, key=lambda run: run.n_items, default=None)

    def clear(self) -> None:
        """Drop all runs."""
        for run in self._runs.copy():
            self._drop(run)

    def expire(self) -> None:
        """Drop the runs that have not grown since the last call."""
        for run in self._runs.copy():
            if not run.grown:
                self._drop(run)
            run.grown = False
