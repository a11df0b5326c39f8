"""The lines of the table, and what of the goals a family falls short of beyond chance."""

from collections.abc import Iterator, Mapping
import math

import numpy as np

from benchmarks.families.family import Family
from benchmarks.families.tally import best, Rate, Tally

OURS = 'ours'
COLUMNS = (
    'family',
    'by',
    'runs',
    'recall ζfT < 0.5',
    '0.5 to 2',
    '> 2',
    'false modes a run',
    'lines as modes',
    'modes as lines, by ζfT',
    'lines a run that are none',
    '2σ of f',
    '2σ of ζ',
    '2σ of shapes',
    'f, ζ over the law (rms)',
    'f, ζ over the bound',
    'MAC loss within 2σ',
    'shapes wrong and sure',
    'CPU s, x real time',
    'falls short',
)
RECALL, FALSE, LINES, HONEST = 0.99, 0.02, 0.01, (0.93, 0.97)
CHANCE = 2.0
"""Standard errors within which a goal is taken as reached."""


def rows_of(family: Family, tallies: Mapping[str, Tally]) -> list[list[str]]:
    """Return the lines of a family: ours, and below it the peer's best where there is one."""
    ours = tallies[OURS]
    others = {who: tally for who, tally in tallies.items() if who != OURS}
    peer = others[best(others)] if others else None
    title = f'{family.name}: {family.what}'
    rows = [[title, OURS, *_cells(ours), ', '.join(short(ours, peer)) or 'nothing']]
    if peer is not None:
        rows.append(['', best(others), *_cells(peer), ''])
    return rows


def _cells(tally: Tally) -> list[str]:
    cpu_s = np.array([v.cpu_s for v in tally.verdicts])
    speed = tally.total('duration_s') / max(1e-9, float(cpu_s.sum()))
    n_losses = sum(len(v.losses) for v in tally.verdicts)
    law, bound = ([tally.scatter(first + part) for part in range(2)] for first in (1, 3))
    return [
        str(len(tally.verdicts)),
        *(str(tally.recall(place)) for place in range(3)),
        str(tally.each_run('n_false')),
        _of(tally.total('n_lines_as_modes'), tally.total('n_lines')),
        ', '.join(map(str, tally.modes_as_lines)),
        str(tally.each_run('n_false_lines')),
        str(tally.inside(0)),
        str(tally.inside(1)),
        str(tally.shapes),
        ', '.join(f'{middle:.2f} ({rms:.2f})' for middle, rms in law if not math.isnan(rms))
        or '-',
        ', '.join(f'{middle:.2f}' for middle, rms in bound if not math.isnan(rms)) or '-',
        str(tally.losses),
        _of(tally.total('n_sure_and_wrong'), n_losses),
        f'{np.median(cpu_s):.2f}, {speed:.0f}',
    ]


def _of(part: int, whole: int) -> str:
    return f'{part} of {whole}' if whole else '-'


def short(ours: Tally, peer: Tally | None) -> Iterator[str]:
    """Yield what falls short beyond chance."""
    if _below(ours.recall(2), RECALL):
        yield 'recall'
    if _above(ours.each_run('n_false'), FALSE):
        yield 'false modes'
    if ours.total('n_lines_as_modes') > 1 + LINES * ours.total('n_lines'):
        yield 'lines as modes'
    if ours.modes_as_lines[2]:
        yield 'modes as lines'
    for what, inside in (('f', ours.inside(0)), ('ζ', ours.inside(1)), ('shapes', ours.shapes)):
        if _below(inside, HONEST[0]) or _above(inside, HONEST[1]):
            yield f'σ of {what}'
    if ours.total('n_sure_and_wrong'):
        yield 'shapes wrong and sure'
    if peer is not None and _below(ours.found_more(peer), 0.0):
        yield f'recall {-ours.found_more(peer).value:.2f} below the peer'
    if peer is not None and _above(ours.false_more(peer), 0.0):
        yield f'{ours.false_more(peer).value:.2f} more false modes than the peer'


def _below(rate: Rate, least: float) -> bool:
    return rate.n > 0 and rate.value + CHANCE * _error(rate, least) < least


def _above(rate: Rate, most: float) -> bool:
    return rate.n > 0 and rate.value - CHANCE * _error(rate, most) > most


def _error(rate: Rate, goal: float) -> float:
    """Return the standard error, at least that of independent trials at the goal."""
    return max(rate.error, math.sqrt(goal * (1.0 - goal) / rate.n))
