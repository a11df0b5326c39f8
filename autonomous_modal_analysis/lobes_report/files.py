"""Files of stability lobes: lobes.json, lobes.csv, report.html."""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from autonomous_modal_analysis.export import export_table, Table
from autonomous_modal_analysis.identified.results import file_header, json_text, plain
from autonomous_modal_analysis.lobes_report.page import render_lobes
from machining.lobes import Chart, Lobes
from modal_core.files.atomic_file import write_text
from modal_core.files.version import software

FILES = ('lobes.json', 'lobes.csv', 'report.html')
FORMAT_VERSION = 1
COLUMNS = (
    'feed_deg', 'speed_rpm', 'limit_m', 'mean_limit_m', 'safe_depth_m', 'chatter_hz',
)  # fmt: skip


Poses = Sequence[dict[str, Any]]
"""Poses that were looked at, of `LobesResult.poses`; empty where the tool is of no map."""


def lobes_json(found: Lobes, poses: Poses = ()) -> dict[str, Any]:
    """Return stability lobes as plain values; None where there is no limit, or no number."""
    return {
        **({'poses': list(poses)} if poses else {}),
        'proposals': [plain(each) for each in found.proposals],
        'charts': [_chart_json(chart, found.settings.risk) for chart in found.charts],
        'remarks': list(found.remarks),
        'cut': plain(asdict(found.settings)),
    }


def save_lobes(folder: Path, found: Lobes, name: str, poses: Poses = ()) -> None:
    """Write the files into a folder, each whole or not at all."""
    folder.mkdir(parents=True, exist_ok=True)
    file = file_header(FORMAT_VERSION, tool=name)
    write_text(folder / FILES[0], json_text({'file': file, **lobes_json(found, poses)}))
    export_table(folder / FILES[1], lobes_table(found, name))
    write_text(folder / FILES[2], render_lobes(found, name, poses))


def _columns(chart: Chart, risk: float) -> dict[str, Any]:
    safe = np.full(len(chart.limit.speed_rpm), np.nan)
    if chart.sample is not None:
        safe = chart.safe_depth_m(risk)
    values = (chart.limit.depth_m, chart.mean.depth_m, safe, chart.mean.chatter_hz)
    return {'speed_rpm': chart.limit.speed_rpm, **dict(zip(COLUMNS[2:], values, strict=True))}


def _chart_json(chart: Chart, risk: float) -> dict[str, Any]:
    theory = 'mean' if chart.periods is None else 'periods'
    own: dict[str, Any] = {'feed_deg': chart.feed_deg, 'theory': theory, **_columns(chart, risk)}
    plained = plain(own)
    assert isinstance(plained, dict)  # noqa: S101  a mapping stays one
    return plained


def lobes_table(found: Lobes, name: str) -> Table:
    """Return the limits of all charts, one row per feed direction and spindle speed."""
    columns: dict[str, list[float]] = {column: [] for column in COLUMNS}
    for chart in found.charts:
        own = _columns(chart, found.settings.risk)
        columns['feed_deg'] += [chart.feed_deg] * len(own['speed_rpm'])
        for column, values in own.items():
            # Without a limit infinite: no number of a table.
            columns[column] += [x if np.isfinite(x) else np.nan for x in map(float, values)]
    return Table.of(columns, {'tool': name, 'software': software()})
