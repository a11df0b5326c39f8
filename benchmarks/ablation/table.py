"""What every stage is worth, as a table."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.ablation.stages import STAGES_OFF

WHOLE = 'all stages'
GONE = ' (gone since)'
CAPPED = 6.0
"""Errors over the law beyond this count as this: one outlier shall not decide."""
COLUMNS = (
    'without',
    'records changed',
    'modes found',
    'false modes',
    'f beyond 2σ',
    'ζ beyond 2σ',
    'shape parts beyond 2σ',
    'errors of f over the law, squared',
    'of ζ',
    'lines that are none',
    'pays',
)
WORSE = (-1, 1, 1, 1, 1, 1, 1, 1)
"""Sign of each difference where a record is worse."""


def _figures(verdict: Mapping[str, Any]) -> list[float]:
    """Return what is compared of a record, in the order of the columns."""
    errors = np.minimum(np.abs([each[1:3] for each in verdict['errors']]), CAPPED).reshape(-1, 2)
    return [
        sum(verdict['found']),
        verdict['n_false'] + verdict['n_lines_as_modes'],
        *(sum(each[part] is False for each in verdict['inside']) for part in range(2)),
        sum(n - inside for inside, n in verdict['shapes']),
        *np.sum(errors**2, axis=0),
        verdict['n_false_lines'],
    ]


def rows_of(entries: Sequence[Mapping[str, Any]]) -> tuple[list[list[str]], int]:
    """Return a line for every stage, what changes without it, and the number of records."""
    by_stage: dict[str, dict[tuple[str, int], list[float]]] = defaultdict(dict)
    for entry in entries:
        verdict = entry['verdict']
        by_stage[entry['stage']][verdict['family'], verdict['seed']] = _figures(verdict)
    whole = by_stage.pop(WHOLE)
    every = np.array(list(whole.values()))
    rows = [['nothing: the sums', '-', *(f'{total:.0f}' for total in every.sum(axis=0)), '']]
    for name, own in by_stage.items():
        change = np.array([np.subtract(own[key], whole[key]) for key in own if key in whole])
        here = any(stage.name == name for stage in STAGES_OFF)
        rows.append(_row(name if here else name + GONE, change))
    return rows, len(whole)


def _row(name: str, change: NDArray[np.float64]) -> list[str]:
    n = len(change)
    changed = int(np.count_nonzero(np.any(np.abs(change) > 1e-9, axis=1)))
    total, error = change.sum(axis=0), math.sqrt(n) * change.std(axis=0)
    cells = [
        f'{value:+.0f} ± {spread:.0f}' if spread else '0'
        for value, spread in zip(total, error, strict=True)
    ]
    pays = any(
        sign * value > 2.0 * spread > 0.0
        for sign, value, spread in zip(WORSE, total, error, strict=True)
    )
    return [name, f'{changed} of {n}', *cells, 'yes' if pays else '']
