"""Random families of structures: what is found, made up and promised, family by family.

A record is determined by its family and its seed.  Seeds below 800,000 are for development, those
from 850,000 for --quick, those from 880,000 for the report.  The whole report is kept in
docs/measured/results; --quick is held against it.
"""

import argparse
from collections import defaultdict
from collections.abc import Sequence
import itertools
import json
from pathlib import Path
import sys
import warnings

from benchmarks import peers
from benchmarks.families.family import FAMILIES
from benchmarks.families.judge import Verdict
from benchmarks.families.peer import name_of, PRESETS
from benchmarks.families.rows import COLUMNS, OURS, rows_of
from benchmarks.families.series import run, Task
from benchmarks.families.store import Store
from benchmarks.families.tally import regressions, Tally
from benchmarks.results import FOLDER, versions, write_rows

QUICK_SEED, REPORT_SEED = 850_000, 880_000
QUICK_RUNS, QUICK_MINUTES = 12, 8.0
RUNS, MINUTES = 60, 110.0
Verdicts = dict[str, dict[str, list[Verdict]]]
"""By family and by who."""


def main(words: Sequence[str] | None = None) -> int:
    """Run, print the table; return 1 where --quick found a regression."""
    chosen = _parser().parse_args(words)
    warnings.simplefilter('ignore')
    seeds, minutes = _extent(chosen)
    names = chosen.family or list(FAMILIES)
    store = Store(chosen.store)
    tasks, known = _tasks(chosen, names, seeds, store)
    verdicts: Verdicts = {name: defaultdict(list) for name in names}
    for found in run(tasks, chosen.workers, minutes):
        store.keep((who, verdict) for who, verdict in found.items() if who != OURS)
        if chosen.verbose and OURS in found:
            print('\n  '.join(filter(None, [*found[OURS].notes, found[OURS].failed])), flush=True)
        first = next(iter(found.values()))
        for who, verdict in {**known[first.family, first.seed], **found}.items():
            verdicts[verdict.family][who].append(verdict)
    rows, counts = _table(verdicts)
    print(f'| {" | ".join(COLUMNS)} |\n|{"---|" * len(COLUMNS)}')
    for row in rows:
        print(f'| {" | ".join(row)} |')
    whole = not (chosen.quick or chosen.ours or chosen.seeds or chosen.family)
    if rows and (chosen.keep or whole):
        where = (*versions(), f'seeds from {seeds[0]}')
        write_rows('families', COLUMNS, rows, where, counts)
    return worse_families(counts) if chosen.quick else 0


def _extent(chosen: argparse.Namespace) -> tuple[range, float]:
    """Return the seeds and the time [min]."""
    first, n_runs = (QUICK_SEED, QUICK_RUNS) if chosen.quick else (REPORT_SEED, RUNS)
    seeds = range(*chosen.seeds) if chosen.seeds else range(first, first + n_runs)
    return seeds, chosen.minutes or (QUICK_MINUTES if chosen.quick else MINUTES)


def _tasks(
    chosen: argparse.Namespace, names: Sequence[str], seeds: range, store: Store
) -> tuple[list[Task], dict[tuple[str, int], dict[str, Verdict]]]:
    """Return what is to be run, all families of a seed before the next seed, and what is known."""
    presets = () if chosen.quick or chosen.ours else PRESETS
    if presets and not peers.installed('pyoma2'):
        presets = ()
        print('pyOMA2 is not installed: ours only', file=sys.stderr)
    tasks, known = [], {}
    for seed, name in itertools.product(seeds, names):
        known[name, seed] = store.known(name, seed) if presets else {}
        left = tuple(preset for preset in presets if name_of(preset) not in known[name, seed])
        if left or not chosen.peer:
            tasks.append(Task(name, seed, not chosen.peer, left))
    return tasks, known


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog='benchmarks families', description=__doc__)
    parser.add_argument('--quick', action='store_true', help='ten minutes; fails when worse')
    parser.add_argument('--ours', action='store_true', help='without the peer')
    parser.add_argument('--peer', action='store_true', help='the peer alone, for the store')
    parser.add_argument('--store', type=Path, help='file that keeps what the peer made of records')
    parser.add_argument('--seeds', nargs=2, type=int, metavar=('FIRST', 'END'))
    parser.add_argument('--family', action='append', choices=list(FAMILIES))
    parser.add_argument('--verbose', action='store_true', help='what was wrong in each record')
    parser.add_argument('--workers', type=int, default=2)
    parser.add_argument('--minutes', type=float, help='begin no record after these')
    parser.add_argument('--keep', action='store_true', help='keep the figures of some seeds too')
    return parser


def _table(
    verdicts: Verdicts,
) -> tuple[list[list[str]], dict[str, dict[str, int]]]:
    """Return the rows, ours above the peer's best, and what later runs are held against."""
    rows, counts = [], {}
    for name, by_whom in verdicts.items():
        if by_whom[OURS]:
            tallies = {who: Tally(each) for who, each in by_whom.items()}
            rows += rows_of(FAMILIES[name], tallies)
            counts[name] = tallies[OURS].counts()
    return rows, counts


def worse_families(counts: dict[str, dict[str, int]]) -> int:
    """Name the families that are worse than the figures kept, beyond chance, alone or together."""
    kept = FOLDER / 'families.json'
    if not kept.exists():
        print('no figures to compare with', file=sys.stderr)
        return 0
    before = json.loads(kept.read_text())['counts']
    pairs = {name: (now, before[name]) for name, now in counts.items() if name in before}
    if pairs:
        now, then = (_sum(each) for each in zip(*pairs.values(), strict=True))
        pairs['the sum of all'] = now, then
    worse = {name: regressions(*pair) for name, pair in pairs.items()}
    for name, what in worse.items():
        if what:
            print(f'{name} is worse: {"; ".join(what)}; before: {pairs[name][1]}', file=sys.stderr)
    return int(any(worse.values()))


def _sum(counts: Sequence[dict[str, int]]) -> dict[str, int]:
    return {what: sum(each[what] for each in counts) for what in counts[0]}


if __name__ == '__main__':
    sys.exit(main())
