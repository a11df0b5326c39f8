"""Stability lobes on a terminal."""

import math

from rich.markup import escape
from rich.table import Table

from autonomous_modal_analysis.lobes_report.words import cut_words, HEADINGS
from autonomous_modal_analysis.terminal import OUTPUT
from machining.lobes import Lobes


def show_lobes(found: Lobes, name: str) -> None:
    """Print the cuts that are proposed, the least limits, and remarks."""
    table = Table(title=escape(name), title_justify='left')
    for heading in HEADINGS:
        table.add_column(escape(heading), justify='right')
    for proposal in found.proposals:
        table.add_row(*cut_words(proposal))
    if found.proposals:
        OUTPUT.print(table)
    else:
        OUTPUT.print('no cut is proposed')
    for chart in found.charts:
        least = float(chart.limit.depth_m.min())
        said = f'{1e3 * least:.3g} mm' if math.isfinite(least) else 'none found'
        theory = 'mean force' if chart.periods is None else 'semi-discretisation'
        OUTPUT.print(f'feed {chart.feed_deg:g}°: least limit {said} ({theory})')
    for remark in found.remarks:
        OUTPUT.print(f'note: {escape(remark)}', soft_wrap=True)
