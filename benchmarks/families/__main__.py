"""Random families of structures: what is found, made up and promised, family by family.

A record is determined by its family and its seed.  Seeds below 800,000 are for development, those
from 850,000 for --quick, those from 880,000 for the report.
"""

import argparse
from collections import defaultdict
from collections.abc import Sequence
import json
import sys
import warnings

from benchmarks.families.family import FAMILIES
from benchmarks.families.judge import Verdict
from benchmarks.families.series import run
from benchmarks.families.tally import COLUMNS, regressions, Tally
from benchmarks.results import FOLDER

QUICK_SEED, REPORT_SEED = 850_000, 880_000
QUICK_RUNS, QUICK_MINUTES = 12, 8.0
RUNS, MINUTES = 60, 110.0


def main(words: Sequence[str] | None = None) -> int:
    """Run, print the table; return 1 where --quick found a regression."""
    parser = argparse.ArgumentParser(prog='benchmarks families', description=__doc__)
    parser.add_argument('--quick', action='store_true', help='ten minutes; fails when worse')
    parser.add_argument('--seeds', nargs=2, type=int, metavar=('FIRST', 'END'))
    parser.add_argument('--family', action='append', choices=list(FAMILIES))
    parser.add_argument('--verbose', action='store_true', help='what was wrong in each record')
    parser.add_argument('--workers', type=int, default=2)
    parser.add_argument('--minutes', type=float, help='begin no record after these')
    chosen = parser.parse_args(words)
    warnings.simplefilter('ignore')
    first, n_runs = (QUICK_SEED, QUICK_RUNS) if chosen.quick else (REPORT_SEED, RUNS)
    seeds = range(*chosen.seeds) if chosen.seeds else range(first, first + n_runs)
    minutes = chosen.minutes or (QUICK_MINUTES if chosen.quick else MINUTES)
    verdicts: dict[str, list[Verdict]] = defaultdict(list)
    for found in run(chosen.family or list(FAMILIES), seeds, chosen.workers, minutes):
        ours = found['ours']
        verdicts[ours.family].append(ours)
        if chosen.verbose:
            print('\n  '.join([*ours.notes, ours.failed]), flush=True)
    tallies = {name: Tally(each) for name, each in verdicts.items()}
    print(f'| {" | ".join(COLUMNS)} |\n|{"---|" * len(COLUMNS)}')
    for tally in tallies.values():
        print(f'| {" | ".join(tally.row())} |')
    return _worse(tallies) if chosen.quick else 0


def _worse(tallies: dict[str, Tally]) -> int:
    """Name the families that are worse than the figures kept, beyond chance."""
    kept = FOLDER / 'families.json'
    if not kept.exists():
        print('no figures to compare with', file=sys.stderr)
        return 0
    before = json.loads(kept.read_text())['counts']
    worse = {
        name: regressions(tally.counts(), before[name])
        for name, tally in tallies.items()
        if name in before
    }
    for name, what in worse.items():
        if what:
            print(f'{name} is worse: {"; ".join(what)}; before: {before[name]}', file=sys.stderr)
    return int(any(worse.values()))


if __name__ == '__main__':
    sys.exit(main())
