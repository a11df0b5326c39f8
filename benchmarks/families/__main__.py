"""Random families of structures: what is found, made up and promised, family by family.

A record is determined by its family and its seed.  Seeds below 800,000 are for development, those
from 850,000 for --quick, those from 880,000 for the report.  The whole report is kept in
docs/measured/results; --quick is held against it.
"""

import argparse
from collections import defaultdict
from collections.abc import Sequence
import json
import sys
import warnings

from benchmarks import peers
from benchmarks.families.family import FAMILIES
from benchmarks.families.judge import Verdict
from benchmarks.families.series import OURS, run, Task
from benchmarks.families.tally import best, COLUMNS, regressions, Tally
from benchmarks.results import FOLDER, versions, write_rows

QUICK_SEED, REPORT_SEED = 850_000, 880_000
QUICK_RUNS, QUICK_MINUTES = 12, 8.0
RUNS, MINUTES = 60, 110.0


def main(words: Sequence[str] | None = None) -> int:
    """Run, print the table; return 1 where --quick found a regression."""
    chosen = _parser().parse_args(words)
    warnings.simplefilter('ignore')
    with_peer = not (chosen.quick or chosen.ours)
    if with_peer and not peers.installed('pyoma2'):
        with_peer = False
        print('pyOMA2 is not installed: ours only', file=sys.stderr)
    first, n_runs = (QUICK_SEED, QUICK_RUNS) if chosen.quick else (REPORT_SEED, RUNS)
    seeds = range(*chosen.seeds) if chosen.seeds else range(first, first + n_runs)
    names = chosen.family or list(FAMILIES)
    tasks = [Task(name, seed, with_peer) for seed in seeds for name in names]
    minutes = chosen.minutes or (QUICK_MINUTES if chosen.quick else MINUTES)
    verdicts: dict[str, dict[str, list[Verdict]]] = {name: defaultdict(list) for name in names}
    for found in run(tasks, chosen.workers, minutes):
        for who, verdict in found.items():
            verdicts[verdict.family][who].append(verdict)
        if chosen.verbose:
            print('\n  '.join(filter(None, [*found[OURS].notes, found[OURS].failed])), flush=True)
    rows, counts = _table(verdicts)
    print(f'| {" | ".join(COLUMNS)} |\n|{"---|" * len(COLUMNS)}')
    for row in rows:
        print(f'| {" | ".join(row)} |')
    if chosen.keep or not (chosen.quick or chosen.ours or chosen.seeds or chosen.family):
        where = (*versions(), f'seeds from {seeds[0]}')
        write_rows('families', COLUMNS, rows, where, counts)
    return _worse(counts) if chosen.quick else 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog='benchmarks families', description=__doc__)
    parser.add_argument('--quick', action='store_true', help='ten minutes; fails when worse')
    parser.add_argument('--ours', action='store_true', help='without the peer')
    parser.add_argument('--seeds', nargs=2, type=int, metavar=('FIRST', 'END'))
    parser.add_argument('--family', action='append', choices=list(FAMILIES))
    parser.add_argument('--verbose', action='store_true', help='what was wrong in each record')
    parser.add_argument('--workers', type=int, default=2)
    parser.add_argument('--minutes', type=float, help='begin no record after these')
    parser.add_argument('--keep', action='store_true', help='keep the figures of some seeds too')
    return parser


def _table(
    verdicts: dict[str, dict[str, list[Verdict]]],
) -> tuple[list[list[str]], dict[str, dict[str, int]]]:
    """Return the rows, ours above the peer's best, and what later runs are held against."""
    rows, counts = [], {}
    for name, by_whom in verdicts.items():
        tallies = {who: Tally(each) for who, each in by_whom.items()}
        ours = tallies.pop(OURS, None)
        if ours is None:
            continue
        rows.append(ours.row(name, OURS))
        counts[name] = ours.counts()
        if tallies:
            who = best(tallies)
            rows.append(tallies[who].row('', who))
    return rows, counts


def _worse(counts: dict[str, dict[str, int]]) -> int:
    """Name the families that are worse than the figures kept, beyond chance."""
    kept = FOLDER / 'families.json'
    if not kept.exists():
        print('no figures to compare with', file=sys.stderr)
        return 0
    before = json.loads(kept.read_text())['counts']
    worse = {
        name: regressions(now, before[name]) for name, now in counts.items() if name in before
    }
    for name, what in worse.items():
        if what:
            print(f'{name} is worse: {"; ".join(what)}; before: {before[name]}', file=sys.stderr)
    return int(any(worse.values()))


if __name__ == '__main__':
    sys.exit(main())
