"""Independent work, as much at once as there are processors."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
import ctypes
import multiprocessing
import os
import signal
import sys
import threading
from typing import Any, TypeVar

from threadpoolctl import threadpool_limits

from modal_core.errors import ModalAnalysisError
from modal_core.work.progress import Progress

Item = TypeVar('Item')
Result = TypeVar('Result')
SET_PARENT_DEATH_SIGNAL = 1  # linux/prctl.h
ENDED_FROM_OUTSIDE = 'a process was ended from outside'
# What forked processes find: the work and its items.
_shared: list[tuple[Callable[[Any], Any], Sequence[Any]]] = []


def side_by_side(
    work: Callable[[Item], Result],
    items: Sequence[Item],
    progress: Progress = lambda _: None,
) -> list[Result]:
    """Return the results of work on every item, in order.

    Processes are forked: the work and its items are there without being copied, changes they make
    to anything are lost, and only results are sent back, by pickle.  Within such a process, or on
    one processor, items are worked on one after the other.

    Parameters
    ----------
    work : callable
        Of one item.
    items : sequence
        What is to be worked on.
    progress : callable
        Takes the fraction done.

    Raises
    ------
    ModalAnalysisError
        A process was ended from outside.
    """
    processes = min(len(items), n_processors())
    if processes < 2:
        return _told((work(item) for item in items), len(items), progress)
    before = multiprocessing.active_children()
    _shared.append((work, items))
    try:
        fork = multiprocessing.get_context('fork')
        with ProcessPoolExecutor(processes, fork, begin) as pool:
            try:
                # Not ``pool.map``: it takes back what has not begun, and the pool's thread, which
                # then learns of the processes' end, cannot tell those: a traceback.
                with signals_wait():
                    begun = [pool.submit(_result, number) for number in range(len(items))]
                return _told((future.result() for future in begun), len(begun), progress)
            except BrokenProcessPool as error:
                raise ModalAnalysisError(
                    ENDED_FROM_OUTSIDE,
                    found=f'{processes} at work',
                    advice='if memory ran out, restrict it to one processor: taskset -c 0',
                ) from error
            except BaseException:  # nobody waits for work that is not wanted any more
                for child in set(multiprocessing.active_children()) - set(before):
                    child.kill()
                raise
    finally:
        _shared.clear()


def _told(results: Iterable[Result], n_items: int, progress: Progress) -> list[Result]:
    found = []
    for result in results:
        found.append(result)
        progress(len(found) / n_items)
    return found


def n_processors() -> int:
    """Return how many processes may work at once; one within a process that is one of several."""
    is_one_of_several = bool(_shared) or multiprocessing.current_process().daemon
    return 1 if is_one_of_several else len(os.sched_getaffinity(0))


def processor_time_s() -> float:
    """Return the processor time of this process and of those it has waited for [s]."""
    return sum(os.times()[:4])


def begin() -> None:
    """End with the parent, which alone answers Ctrl-C and alone writes to the terminal's display.

    A display may have been refreshed at the moment of forking: whoever writes through it would
    wait for ever.  Processes share the processors: their matrices have one thread each.
    """
    threadpool_limits(limits=1, user_api='blas')
    ctypes.CDLL(None).prctl(SET_PARENT_DEATH_SIGNAL, signal.SIGKILL)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    sys.stdout, sys.stderr = sys.__stdout__, sys.__stderr__


@contextmanager
def signals_wait() -> Iterator[None]:
    """Answer Ctrl-C and SIGTERM afterwards: what handlers raise in a hook of fork is lost."""
    came: list[int] = []
    handlers = {}
    if threading.current_thread() is threading.main_thread():
        for ending in (signal.SIGINT, signal.SIGTERM):
            handler = signal.getsignal(ending)
            if callable(handler):
                handlers[ending] = handler
                signal.signal(ending, lambda number, _: came.append(number))
    try:
        yield
    finally:
        for ending, handler in handlers.items():
            signal.signal(ending, handler)
    for number in came:
        signal.raise_signal(number)


def _result(number: int) -> Any:
    ((work, items),) = _shared
    return work(items[number])
