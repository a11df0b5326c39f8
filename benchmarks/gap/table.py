"""Campaigns of the gap matrix as rows of the tables in the documentation."""

from collections.abc import Sequence
from typing import Any

COLUMNS = (
    'hidden',
    'seed',
    'verdict',
    'held-out gap, before → after (noise)',
    'parameter: true, found ± σ',
    'CPU-s',
)


def table_rows(campaigns: Sequence[dict[str, Any]]) -> list[list[str]]:
    """Return one row a campaign, as ``benchmarks/gap/matrix.py --out`` keeps them."""
    return [_row(campaign) for campaign in campaigns]


def _row(campaign: dict[str, Any]) -> list[str]:
    hidden = ' and '.join(
        f'{kind}, {place}' if place else kind for kind, place in campaign['truth']
    )
    found = ', '.join(kind for kind, _ in campaign['found'])
    verdict = campaign['verdict'] + (f': {found}' if found else '')
    gap = f'{campaign["gap_before"]:.3f} → {campaign["gap_after"]:.3f} ({campaign["noise"]:.3f})'
    estimate = ''
    if campaign['estimate']:
        true, value, sigma = campaign['estimate']
        estimate = f'{true:.4g}, {value:.4g} ± {sigma:.2g}'
    seed, cpu = str(campaign['seed']), f'{campaign["cpu_s"]:.0f}'
    return [hidden or 'nothing', seed, verdict, gap, estimate, cpu]
