"""The modal report: one self-contained HTML file an engineer can hand on."""

from autonomous_modal_analysis.report.content import ReportContent
from autonomous_modal_analysis.report.page import render_report, write_report
from autonomous_modal_analysis.report.truth import match_truth, TrueMode

__all__ = [
    'ReportContent',
    'TrueMode',
    'match_truth',
    'render_report',
    'write_report',
]
