"""The report: one self-contained HTML file an engineer can hand on."""

from autonomous_modal_analysis.report.content import ReportContent, Spectrum
from autonomous_modal_analysis.report.geometry import (
    Geometry,
    interpolate_displacements,
    sensor_displacements,
)
from autonomous_modal_analysis.report.page import render_report, write_report
from autonomous_modal_analysis.report.truth import match_truth, TrueMode

__all__ = [
    'Geometry',
    'ReportContent',
    'Spectrum',
    'TrueMode',
    'interpolate_displacements',
    'match_truth',
    'render_report',
    'sensor_displacements',
    'write_report',
]
