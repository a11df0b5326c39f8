"""The report of a modal map.

In come a map and two axes; out goes one HTML page.
"""

from autonomous_modal_analysis.map_report.page import render_map

__all__ = ['render_map']
