"""The result for people: one self-contained HTML page.

In come a found gap and its comparison; out go the page and the lines of its summary.
"""

from model_gap.report.first_page import COMPARING, FirstPage, look_lines
from model_gap.report.page import write_report
from model_gap.report.telling_words import telling_lines
from model_gap.report.words import effect_words, headline, summary_lines

__all__ = [
    'COMPARING',
    'FirstPage',
    'effect_words',
    'headline',
    'look_lines',
    'summary_lines',
    'telling_lines',
    'write_report',
]
