"""Records of families run in processes, one seed of every family after the other."""

from collections.abc import Iterator, Sequence
from concurrent.futures import as_completed, Future, ProcessPoolExecutor
from dataclasses import dataclass
import itertools
import signal
import sys
import time
from types import FrameType

from benchmarks.families.family import FAMILIES
from benchmarks.families.judge import Verdict
from benchmarks.families.ours import ours
from benchmarks.families.peer import name_of, peer, PRESETS
from benchmarks.families.record import draw

OURS = 'ours'
LONGEST_S = 600.0
"""Processor time after which a record is given up."""


@dataclass(frozen=True)
class Task:
    """A record, and whether the peer sees it too."""

    family: str
    seed: int
    with_peer: bool


def examine(task: Task) -> dict[str, Verdict]:
    """Return the verdicts on a record by who identified it."""
    record = draw(FAMILIES[task.family], task.seed)
    signal.setitimer(signal.ITIMER_PROF, LONGEST_S)
    verdicts = {OURS: ours(record)}
    if task.with_peer:
        for preset in PRESETS:
            signal.setitimer(signal.ITIMER_PROF, LONGEST_S)
            verdicts[name_of(preset)] = peer(record, preset)
    signal.setitimer(signal.ITIMER_PROF, 0)
    for verdict in verdicts.values():
        verdict.notes.insert(0, str(record))
    return verdicts


def run(tasks: Sequence[Task], workers: int, minutes: float) -> Iterator[dict[str, Verdict]]:
    """Yield verdicts as they come; no record is begun when the time is over."""
    end = time.monotonic() + 60.0 * minutes
    left = iter(tasks)
    done = 0
    with ProcessPoolExecutor(workers, initializer=_bound) as pool:
        waiting = {pool.submit(examine, task) for task in itertools.islice(left, 2 * workers)}
        while waiting:
            finished: Future[dict[str, Verdict]] = next(as_completed(waiting))
            waiting.remove(finished)
            if time.monotonic() < end:
                waiting |= {pool.submit(examine, task) for task in itertools.islice(left, 1)}
            done += 1
            verdicts = finished.result()
            _progress(verdicts[OURS], f'{done}/{len(tasks)}')
            yield verdicts
    if done < len(tasks):
        print(f'time is over after {done} of {len(tasks)} records', file=sys.stderr)


def _progress(verdict: Verdict, where: str) -> None:
    print(
        f'{where} {verdict.family} {verdict.seed}: found {sum(verdict.found)} of'
        f' {sum(verdict.asked)}, {verdict.n_false} false, {verdict.cpu_s:.1f} s'
        f' {verdict.failed}',
        file=sys.stderr,
        flush=True,
    )


def _bound() -> None:
    """Let a record that takes too long be a finding and no end of the series."""
    signal.signal(signal.SIGPROF, _too_long)


def _too_long(_: int, __: FrameType | None) -> None:
    raise TimeoutError(f'not done after {LONGEST_S:g} s')
