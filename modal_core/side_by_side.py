"""Independent work, as much at once as there are processors."""

from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
import multiprocessing
import os
import signal
from typing import Any, TypeVar

Item = TypeVar('Item')
Result = TypeVar('Result')
# What forked processes find: the work and its items.
_shared: list[tuple[Callable[[Any], Any], Sequence[Any]]] = []


def side_by_side(work: Callable[[Item], Result], items: Sequence[Item]) -> list[Result]:
    """Return the results of work on every item, in order.

    Processes are forked: the work and its items are there without being copied, changes they make
    to anything are lost, and only results are sent back, by pickle.  Within such a process, or on
    one processor, items are worked on one after the other.
    """
    processes = min(len(items), len(os.sched_getaffinity(0)))
    if processes < 2 or _shared:
        return [work(item) for item in items]
    before = multiprocessing.active_children()
    _shared.append((work, items))
    try:
        fork = multiprocessing.get_context('fork')
        with ProcessPoolExecutor(processes, fork, _leave_interrupts) as pool:
            try:
                return list(pool.map(_result, range(len(items))))
            except BaseException:  # nobody waits for work that is not wanted any more
                for child in set(multiprocessing.active_children()) - set(before):
                    child.kill()
                raise
    finally:
        _shared.clear()


def _leave_interrupts() -> None:
    """Let the parent process alone answer Ctrl-C."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _result(number: int) -> Any:
    ((work, items),) = _shared
    return work(items[number])
