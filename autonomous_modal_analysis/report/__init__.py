"""The modal report: one self-contained HTML file an engineer can hand on."""

from autonomous_modal_analysis.report.channel_spectra import channel_spectra
from autonomous_modal_analysis.report.comparison import ComparedState, headline, write_comparison
from autonomous_modal_analysis.report.content import ReportContent
from autonomous_modal_analysis.report.overlay import StateDrawn
from autonomous_modal_analysis.report.page import render_report, write_report
from autonomous_modal_analysis.report.truth import match_truth, TrueMode

__all__ = [
    'ComparedState',
    'ReportContent',
    'StateDrawn',
    'TrueMode',
    'channel_spectra',
    'headline',
    'match_truth',
    'render_report',
    'write_comparison',
    'write_report',
]
