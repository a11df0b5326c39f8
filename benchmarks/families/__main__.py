"""Random families of structures: what is found, made up and promised, family by family.

A record is determined by its family and its seed.  Seeds below 800,000 are for development, those
from 850,000 for --quick, those from 880,000 for the report.  The whole report is kept in
docs/measured/results; what was wrong in each record of --quick, which a later one is held
against, in benchmarks/family_records.json.
"""

import argparse
from collections import defaultdict
from collections.abc import Sequence
import itertools
from pathlib import Path
import sys
import warnings

from benchmarks.families.family import FAMILIES
from benchmarks.families.judge import Verdict
from benchmarks.families.kept_records import keep, worse_than_kept, wrong_in
from benchmarks.families.peer import name_of, PRESETS
from benchmarks.families.rows import COLUMNS, OURS, rows_of
from benchmarks.families.series import run, Task
from benchmarks.families.store import Store
from benchmarks.families.tally import Tally
from benchmarks.identifier import peers
from benchmarks.results import versions, write_rows

QUICK_SEED, REPORT_SEED = 850_000, 880_000
QUICK_RUNS, QUICK_MINUTES = 6, 8.0
RUNS, MINUTES = 60, 110.0
Verdicts = dict[str, dict[str, list[Verdict]]]
"""By family and by who."""


def main(words: Sequence[str] | None = None) -> int:
    """Run, print the table; return 1 where --quick found records worse than they were."""
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
    rows = _table(verdicts)
    print(f'| {" | ".join(COLUMNS)} |\n|{"---|" * len(COLUMNS)}')
    for row in rows:
        print(f'| {" | ".join(row)} |')
    whole = not (chosen.quick or chosen.ours or chosen.seeds or chosen.family)
    if chosen.quick:
        return _quick(chosen, verdicts)
    if rows and (chosen.keep or whole):
        write_rows('families', COLUMNS, rows, (*versions(), f'seeds from {seeds[0]}'))
    return 0


def _quick(chosen: argparse.Namespace, verdicts: Verdicts) -> int:
    wrong = wrong_in(each for by_whom in verdicts.values() for each in by_whom[OURS])
    if chosen.keep:
        keep(wrong)
        return 0
    worse = worse_than_kept(wrong)
    if worse:
        print(f'worse: {worse}', file=sys.stderr)
    return int(bool(worse))


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


def _table(verdicts: Verdicts) -> list[list[str]]:
    """Return the rows, ours above the peer's best."""
    rows = []
    for name, by_whom in verdicts.items():
        if by_whom[OURS]:
            tallies = {who: Tally(each) for who, each in by_whom.items()}
            rows += rows_of(FAMILIES[name], tallies)
    return rows


if __name__ == '__main__':
    sys.exit(main())
