"""One HTML file that shows stability lobes."""

from collections.abc import Sequence
import math
from pathlib import Path
from typing import Any

from markupsafe import Markup
import numpy as np

from autonomous_modal_analysis.lobes_report.words import (
    cut_words,
    HEADINGS,
    POSE_HEADINGS,
    pose_words,
)
from machining.lobes import Chart, Lobes
from modal_core.files.version import software
from modal_reports import course_plot, Mark, number, Page, render, Row, Table

TEMPLATE = Path(__file__).parent / 'templates' / 'lobes.html.j2'
HEADROOM = 1.3
AXES = ('spindle speed [rpm]', 'axial depth [mm]')


def render_lobes(found: Lobes, name: str, poses: Sequence[dict[str, Any]] = ()) -> str:
    """Return the report as one HTML document; names in it are only ever shown as text."""
    cut = found.settings
    values = {
        'name': name,
        'proposals': Table(
            'Proposed cuts',
            [number(heading) for heading in HEADINGS],
            [Row([number(text) for text in cut_words(each)]) for each in found.proposals],
        ),
        'poses': poses_table(poses) if poses else None,
        'remarks': found.remarks,
        'drawings': [_drawing(chart, found) for chart in found.charts],
        'sampled': found.charts[0].sample is not None,
        'risk': f'{100.0 * cut.risk:g}',
        'facts': [
            f'{cut.n_teeth} teeth, {cut.diameter_mm:g} mm',
            f'{cut.way} milling',
            f'{cut.tangential_n_mm2:g} and {cut.radial_n_mm2:g} N/mm²',
        ],
        'provenance': {'software': software(), 'seed': str(cut.seed)},
    }
    return render(Page('Stability lobes', 'The cut that does not chatter', TEMPLATE, values, {}))


def poses_table(poses: Sequence[dict[str, Any]]) -> Table:
    """Return the poses that were looked at."""
    rows = [[number(text) for text in pose_words(each)] for each in poses]
    return Table('Poses', [number(heading) for heading in POSE_HEADINGS], [Row(r) for r in rows])


def _drawing(chart: Chart, found: Lobes) -> Markup:
    marks = [
        Mark(each.speed_rpm, 1e3 * each.depth_m, ', '.join(cut_words(each)))
        for each in found.proposals
        if each.feed_deg == chart.feed_deg
    ]
    deepest = found.settings.max_depth_mm
    shown = 1e3 * chart.limit.depth_m
    most = float(np.max(shown[np.isfinite(shown)], initial=0.0))
    highest = min(deepest, HEADROOM * most) if most else deepest
    curves = [('before', 1e3 * chart.mean.depth_m)]
    if chart.periods is not None:
        curves.append(('after', shown))
    risk, band = found.settings.risk, None
    if chart.sample is not None:
        band = (1e3 * chart.safe_depth_m(risk), 1e3 * chart.safe_depth_m(1.0 - risk))
    title = f'feed at {chart.feed_deg:g}°'
    return course_plot(
        title, AXES, chart.limit.speed_rpm, curves, max(highest, math.ulp(1.0)), band, marks
    )
