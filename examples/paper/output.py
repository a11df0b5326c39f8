"""Tables and findings on the terminal and in docs/explanation/results; or held against those.

What is kept is what the page shows.  When checking, nothing is written: each table is compared
with the kept one, and what differs is remembered.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
import json
import re
from typing import Any

from rich.console import Console
from rich.table import Table

from benchmarks.results import GROUPS, write_rows

WIDTH = 112
FINDINGS = 'paper_findings'
REPRODUCED, PARTLY, NOT_REPRODUCED = 'reproduced', 'in part', 'not reproduced'
NUMBER = re.compile(r'[+-]?\d+(?:\.(\d+))?(?:e[+-]?\d+)?')
# Figures that differ by less come from another processor or library, not from other code:
# relative, and in units of the last digit shown (assumed).
RELATIVE, LAST_DIGITS = 0.05, 2.0


@dataclass(frozen=True)
class Finding:
    """What the paper found, what is seen here, and what that comes to."""

    paper: str
    here: str
    verdict: str


@dataclass
class Keeper:
    """Writes what the page shows, or compares it with what is kept."""

    checks: bool = False
    differences: list[str] = field(default_factory=list)

    def rows(self, name: str, columns: Sequence[str], rows: list[list[str]], title: str) -> None:
        """Keep a table."""
        if self.checks:
            self._compare(name, kept(name), rows)
        else:
            write_rows(name, columns, rows, [title])

    def findings(self, section: str, found: Sequence[Finding]) -> None:
        """Keep the findings of one section; those of the others stay."""
        rows = [[section, each.paper, each.verdict, each.here] for each in found]
        before = kept(FINDINGS)
        if self.checks:
            self._compare(FINDINGS, [row for row in before if row[0] == section], rows)
            return
        others = [row for row in before if row[0] != section]
        columns = ('section', 'finding of the paper', 'verdict', 'here')
        write_rows(FINDINGS, columns, sorted([*others, *rows], key=lambda row: row[0]))

    def _compare(self, name: str, old: list[list[str]], new: list[list[str]]) -> None:
        if len(old) != len(new):
            self.differences.append(f'{name}: {len(old)} rows are kept, {len(new)} computed')
            return
        self.differences += [
            f'{name}, {row[0]}: {was!r} is kept, {now!r} computed'
            for line, row in zip(old, new, strict=True)
            for was, now in zip(line, row, strict=False)
            if not alike(was, now)
        ]


KEEPER = Keeper()


def kept(name: str) -> list[list[str]]:
    """Return the rows that are kept; none where there is no file."""
    path = GROUPS[name].path
    return json.loads(path.read_text())['rows'] if path.exists() else []


def alike(one: str, other: str) -> bool:
    """Return whether two cells say the same, their numbers within what machines differ by."""
    if NUMBER.sub('0', one) != NUMBER.sub('0', other):
        return False
    pairs = zip(NUMBER.finditer(one), NUMBER.finditer(other), strict=True)
    return all(_near(was, now) for was, now in pairs)


def _near(was: re.Match[str], now: re.Match[str]) -> bool:
    values = [float(match.group()) for match in (was, now)]
    unit = 10.0 ** -len(was.group(1) or '')
    if 'e' in was.group():
        unit *= 10.0 ** float(was.group().split('e')[1])
    largest = max(map(abs, values))
    return abs(values[0] - values[1]) <= RELATIVE * largest + LAST_DIGITS * unit


def show_table(
    title: str, columns: Sequence[str], rows: Sequence[Sequence[object]], keep: str = ''
) -> None:
    """Print a table, first column left, the others right; ``keep`` names it in the documents."""
    table: Any = Table(title=title, title_justify='left', title_style='bold')
    for number, column in enumerate(columns):
        table.add_column(column, justify='right' if number else 'left')
    cells = [[str(cell) for cell in row] for row in rows]
    for row in cells:
        table.add_row(*row)
    Console(width=WIDTH).print(table)
    if keep:
        KEEPER.rows(f'paper_{keep}', columns, cells, title)


def show_findings(section: str, found: Sequence[Finding], *, keep: bool) -> None:
    """Print what became of the paper's findings; ``keep`` them for the documents."""
    for each in found:
        say(f'[bold]{each.verdict}[/bold]: {each.paper}\n  here: {each.here}')
    if keep:
        KEEPER.findings(section, found)


def say(text: str) -> None:
    """Print a line of explanation."""
    Console(width=WIDTH, highlight=False).print(text)
