"""The tables of what was tried and of where the gap is, from the mapping that gap.json holds."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from modal_reports import (
    Cell,
    fixed,
    meter,
    number,
    percent,
    Row,
    Table,
    text,
    with_sigma,
)

Found = Mapping[str, Any]


def parameter_words(parameters: Mapping[str, Found]) -> str:
    """Return parameters with deviation and unit."""
    return ', '.join(
        f'{name.replace("_", " ")} {with_sigma(item["value"], item["sigma"], item["unit"])}'
        for name, item in parameters.items()
    )


def candidates_table(
    candidates: Sequence[Found], to_add: float, between: float, rejected: bool = False
) -> Table:
    """Return the explanations that were tried, round by round; none stands out if all fell."""
    gains = [row['log_evidence_gain'] or 0.0 for row in candidates]
    best = max([*gains, 1.0])
    headings = (
        *map(text, ('Round', 'Effect', 'Place', 'Parameters')),
        number('Gain'),
        text('Relative'),
        number('Fitted'),
        number('Held out'),
    )
    firsts = [row['round'] != before for row, before in with_before(candidates, 'round')]
    rows = []
    for row, gain, first in zip(candidates, gains, firsts, strict=True):
        cells = (
            text(str(row['round'])),
            text(row['type'].replace('_', ' ')),
            text(f'{row["location"] or ""} {row["variant"]}'.strip()),
            Cell(parameter_words(row['parameters']), 'free wide'),
            number(fixed(row['log_evidence_gain'], 1)),
            Cell(meter(gain / best), 'chart'),
            number(fixed(row['over_noise'], 2)),
            number(fixed(row['over_noise_heldout'], 2)),
        )
        rows.append(Row(cells, 'best' if first and gain >= to_add and not rejected else ''))
    return Table(
        'explanations tried',
        headings,
        rows,
        ('All of these are rejected: none is an answer. ' if rejected else '')
        + f'Gain of log evidence over the model without the effect ({to_add:g} are needed, '
        f'{between:g} between rivals), and what is left over on fitted and held-out recordings, '
        'times the noise.',
        'none: nothing was worth trying',
    )


def where_table(places: Sequence[Found], kinds: tuple[str, ...]) -> Table:
    """Return what is left over by place."""
    headings = (
        text('Kind'),
        text('Place'),
        number('Before, × noise'),
        number('After'),
        number('Share of the gap'),
    )
    rows = [
        Row(
            (
                text(item['kind']),
                text(item['name']),
                number(fixed(item['over_noise_before'], 2)),
                number(fixed(item['over_noise_after'], 2)),
                number(percent(item['share'])),
            )
        )
        for item in places
        if item['kind'] in kinds
    ]
    return Table('places of the gap', headings, rows)


def with_before(rows: Sequence[Found], key: str) -> Iterator[tuple[Found, object]]:
    """Yield each row with the key's value of the row before."""
    before = None
    for row in rows:
        yield row, before
        before = row[key]
