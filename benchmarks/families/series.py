"""Records of families run in processes, one seed of every family after the other."""

from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
import sys
import time

from benchmarks.families.family import FAMILIES
from benchmarks.families.judge import Verdict
from benchmarks.families.ours import ours
from benchmarks.families.record import draw

Task = tuple[str, int]


def examine(task: Task) -> dict[str, Verdict]:
    """Return the verdicts on the record of a family and a seed, by who identified it."""
    family, seed = task
    record = draw(FAMILIES[family], seed)
    verdicts = {'ours': ours(record)}
    for verdict in verdicts.values():
        verdict.notes.insert(0, str(record))
    return verdicts


def run(
    families: Sequence[str], seeds: Sequence[int], workers: int, minutes: float
) -> Iterator[dict[str, Verdict]]:
    """Yield verdicts, all families of a seed before the next seed, until the time is over."""
    tasks = [(family, seed) for seed in seeds for family in families]
    end = time.monotonic() + 60.0 * minutes
    with ProcessPoolExecutor(workers) as pool:
        for first in range(0, len(tasks), 2 * workers):
            if time.monotonic() > end:
                print(f'time is over after {first} of {len(tasks)}', file=sys.stderr)
                return
            for done, verdicts in enumerate(
                pool.map(examine, tasks[first : first + 2 * workers]), first + 1
            ):
                ours_ = verdicts['ours']
                print(
                    f'{done}/{len(tasks)} {ours_.family} {ours_.seed}: found'
                    f' {sum(ours_.found)}/{sum(ours_.asked)}, {ours_.n_false} false,'
                    f' {ours_.cpu_s:.1f} s {ours_.failed}',
                    file=sys.stderr,
                    flush=True,
                )
                yield verdicts
