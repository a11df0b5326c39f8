"""Every stage of selection and refinement switched off in turn, on the same random records.

What a stage is worth is what the same records lose without it: modes found, modes made up, values
within their deviations, scatter over the law; standard errors are those over records.  The record
is identified as one stretch, as in the headline of `ama identify`, without its windows.

    python -m benchmarks.ablation FILE --seeds 7000 7006     measures, and keeps what it measured
    python -m benchmarks.ablation FILE                       prints the table of it
    python -m benchmarks.ablation FILE --keep                the documentation shows it

Kept are also the rows of before of stages that FILE does not hold.
"""

import argparse
from collections.abc import Sequence
from dataclasses import asdict
import itertools
import json
from pathlib import Path
import sys
from typing import Any
import warnings

from benchmarks.ablation.shared import Shared, verdict_of
from benchmarks.ablation.stages import Stage, STAGES_OFF
from benchmarks.ablation.table import COLUMNS, GONE, rows_of, WHOLE
from benchmarks.families.drawing import draw
from benchmarks.families.family import FAMILIES
from benchmarks.results import FOLDER, versions, write_rows


def measure(file: Path, seeds: range, families: Sequence[str], stages: Sequence[Stage]) -> None:
    """Run every record with all stages and without each; keep the verdicts, one a line."""
    done = {(e['stage'], e['verdict']['family'], e['verdict']['seed']) for e in _entries(file)}
    for seed, family in itertools.product(seeds, families):
        left = [s for s in (None, *stages) if (_name(s), family, seed) not in done]
        if not left:
            continue
        record, shared = draw(FAMILIES[family], seed), Shared()
        for stage in left:
            verdict = verdict_of(record, stage, shared)
            entry = {'stage': _name(stage), 'verdict': asdict(verdict)}
            with file.open('a', encoding='utf-8') as out:
                out.write(json.dumps(entry, ensure_ascii=False) + '\n')
        print(f'{family} {seed}', file=sys.stderr, flush=True)


def _name(stage: Stage | None) -> str:
    return WHOLE if stage is None else stage.name


def _entries(file: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []


def _kept_before(anew: Sequence[Sequence[str]]) -> list[list[str]]:
    """Return the rows kept of stages that were not measured anew."""
    kept = FOLDER / 'ablation.json'
    before = json.loads(kept.read_text())['rows'] if kept.exists() else []
    names = {row[0].removesuffix(GONE) for row in anew}
    return [row for row in before if row[0].removesuffix(GONE) not in names]


def main(words: Sequence[str] | None = None) -> int:
    """Measure, or print the table."""
    parser = argparse.ArgumentParser(prog='benchmarks.ablation', description=__doc__)
    parser.add_argument('file', type=Path, help='keeps the verdicts')
    parser.add_argument('--seeds', nargs=2, type=int, metavar=('FIRST', 'END'))
    parser.add_argument('--family', action='append', choices=list(FAMILIES))
    parser.add_argument('--stage', action='append', choices=[stage.name for stage in STAGES_OFF])
    parser.add_argument('--keep', action='store_true', help='the documentation shows the table')
    chosen = parser.parse_args(words)
    warnings.simplefilter('ignore')
    if chosen.seeds:
        stages = [s for s in STAGES_OFF if not chosen.stage or s.name in chosen.stage]
        measure(chosen.file, range(*chosen.seeds), chosen.family or list(FAMILIES), stages)
    rows, n_records = rows_of(_entries(chosen.file))
    print(f'| {" | ".join(COLUMNS)} |\n|{"---|" * len(COLUMNS)}')
    for row in rows:
        print(f'| {" | ".join(row)} |')
    if chosen.keep:
        rows += _kept_before(rows)
        write_rows('ablation', COLUMNS, rows, (*versions(), f'{n_records} records'))
    return 0


if __name__ == '__main__':
    sys.exit(main())
