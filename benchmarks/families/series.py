"""Records of families run in processes, one seed of every family after the other."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import as_completed, Future, ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
import itertools
import signal
import sys
import time
from types import FrameType

from benchmarks.families.drawing import draw
from benchmarks.families.family import FAMILIES
from benchmarks.families.judge import Verdict
from benchmarks.families.ours import ours
from benchmarks.families.peer import name_of, peer, Preset
from benchmarks.families.rows import OURS

LONGEST_S = 600.0
"""Processor time after which a record is given up."""


@dataclass(frozen=True)
class Task:
    """A record, and who identifies it: ours, and the peer with some presets."""

    family: str
    seed: int
    ours: bool
    presets: tuple[Preset, ...]


def examine(task: Task) -> dict[str, Verdict]:
    """Return the verdicts on a record by who identified it."""
    record = draw(FAMILIES[task.family], task.seed)
    runs: dict[str, Callable[[], Verdict]] = {OURS: partial(ours, record)} if task.ours else {}
    runs |= {name_of(preset): partial(peer, record, preset) for preset in task.presets}
    verdicts = {}
    for who, identify in runs.items():
        signal.setitimer(signal.ITIMER_PROF, LONGEST_S)
        verdicts[who] = identify()
        verdicts[who].notes.insert(0, str(record))
    signal.setitimer(signal.ITIMER_PROF, 0)
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
            for who, verdict in verdicts.items():
                _progress(who, verdict, f'{done}/{len(tasks)}')
            yield verdicts
    if done < len(tasks):
        print(f'time is over after {done} of {len(tasks)} records', file=sys.stderr)


def _progress(who: str, verdict: Verdict, where: str) -> None:
    print(
        f'{where} {verdict.family} {verdict.seed} {who}: found {sum(verdict.found)} of'
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
