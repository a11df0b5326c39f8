"""What was wrong in each record of --quick, kept: a later run is held against the same records.

A record is the same on every computer.  Where nothing changed the same is found in it, but for
rounding; a change that does harm makes more records worse than better.  Other records would not
do: a few of them differ by chance as much as harm does.
"""

from collections.abc import Iterable
import json
from pathlib import Path

from scipy.stats import binom

from benchmarks.families.judge import Verdict
from modal_core.files.atomic_file import write_text

KEPT = Path(__file__).parents[1] / 'family_records.json'
BY_CHANCE = 1e-3
"""Chance that so many of the records that changed are worse where better is as likely."""
Wrong = dict[str, dict[str, int]]
"""Modes missed and made up, by family and seed."""


def wrong_in(verdicts: Iterable[Verdict]) -> Wrong:
    """Return how many modes were missed or made up in each record."""
    found: Wrong = {}
    for verdict in verdicts:
        missed = sum(verdict.asked) - sum(verdict.found)
        found.setdefault(verdict.family, {})[str(verdict.seed)] = missed + verdict.n_made_up
    return found


def keep(wrong: Wrong, path: Path = KEPT) -> None:
    """Keep what was wrong just now."""
    write_text(path, json.dumps(wrong, indent=1) + '\n')


def worse_than_kept(wrong: Wrong, path: Path = KEPT) -> str:
    """Say which records are worse than they were kept; empty where chance may have done it."""
    kept: Wrong = json.loads(path.read_text())
    changes = {
        f'{family} {seed}': number - kept[family][seed]
        for family, records in wrong.items()
        for seed, number in records.items()
        if seed in kept.get(family, {})
    }
    worse = [name for name, change in changes.items() if change > 0]
    n_changed = sum(change != 0 for change in changes.values())
    if binom.sf(len(worse) - 1, n_changed, 0.5) >= BY_CHANCE:
        return ''
    return f'of {len(changes)} records {n_changed} changed, worse are {", ".join(worse)}'
