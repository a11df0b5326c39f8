"""What the peer made of records, kept: it does not change when we do."""

from collections.abc import Iterable
from dataclasses import asdict
import json
from pathlib import Path

from benchmarks.families.judge import Verdict
from benchmarks.results import definition, Group

DECIDES = Group(
    'verdicts',
    (
        *(
            f'benchmarks/families/{name}.py'
            for name in (
                *('bound', 'chance', 'drawing', 'family', 'force', 'judge', 'machine'),
                *('matching', 'motion', 'peer', 'record', 'response', 'structure'),
            )
        ),
        'benchmarks/identifier/plant.py',
        'benchmarks/identifier/scatter.py',
    ),
    '',
)
"""Programs that decide a verdict on the peer."""


class Store:
    """Verdicts in a file, one a line; those of other programs count for nothing.

    Parameters
    ----------
    path : Path or None
        None: nothing is kept.
    """

    def __init__(self, path: Path | None) -> None:
        self._path = path
        self._definition = definition(DECIDES)
        self._known: dict[tuple[str, int], dict[str, Verdict]] = {}
        for line in path.read_text().splitlines() if path is not None and path.exists() else ():
            entry = json.loads(line)
            if entry['definition'] == self._definition:
                self._learn(entry['by'], Verdict(**entry['verdict']))

    def _learn(self, who: str, verdict: Verdict) -> None:
        self._known.setdefault((verdict.family, verdict.seed), {})[who] = verdict

    def known(self, family: str, seed: int) -> dict[str, Verdict]:
        """Return the verdicts on a record by who identified it."""
        return self._known.get((family, seed), {})

    def keep(self, verdicts: Iterable[tuple[str, Verdict]]) -> None:
        """Add verdicts to the file."""
        if self._path is None:
            return
        with self._path.open('a', encoding='utf-8') as file:
            for who, verdict in verdicts:
                entry = {'definition': self._definition, 'by': who, 'verdict': asdict(verdict)}
                file.write(json.dumps(entry, ensure_ascii=False) + '\n')
