"""The result for people: one self-contained HTML page.

In come a found gap and its comparison; out go the page and the lines of its summary.
"""

from model_gap.report.page import write_report
from model_gap.report.words import effect_words, headline, summary_lines

__all__ = ['effect_words', 'headline', 'summary_lines', 'write_report']
