"""Files of stability lobes: lobes.json, lobes.csv, report.html."""

from collections.abc import Sequence
import csv
from dataclasses import asdict
import io
from pathlib import Path
from typing import Any

import numpy as np

from autonomous_modal_analysis.lobes_report.page import render_lobes
from autonomous_modal_analysis.results import file_header, json_text, plain
from machining.lobes import Chart, Lobes
from modal_core.atomic_file import write_text

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
    write_text(folder / FILES[1], _csv_text(found))
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


def _csv_text(found: Lobes) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator='\n')
    writer.writerow(COLUMNS)
    for chart in found.charts:
        columns = _columns(chart, found.settings.risk)
        for row in zip(*columns.values(), strict=True):
            numbers = [plain(float(value)) for value in row]
            writer.writerow([chart.feed_deg, *('' if n is None else n for n in numbers)])
    return text.getvalue()
