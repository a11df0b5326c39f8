"""Stability lobes on a terminal."""

from collections.abc import Sequence
import math
from typing import Any

from rich.markup import escape
from rich.table import Table

from autonomous_modal_analysis.console.terminal import OUTPUT
from autonomous_modal_analysis.lobes_report.words import (
    cut_words,
    HEADINGS,
    POSE_HEADINGS,
    pose_words,
)
from machining.lobes import Lobes


def show_lobes(found: Lobes, name: str, poses: Sequence[dict[str, Any]] = ()) -> None:
    """Print the poses looked at, the cuts that are proposed, the least limits, and remarks."""
    if poses:
        shown = Table(title='poses', title_justify='left')
        for heading in POSE_HEADINGS:
            shown.add_column(escape(heading), justify='right')
        for pose in poses:
            shown.add_row(*(escape(text) for text in pose_words(pose)))
        OUTPUT.print(shown)
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
