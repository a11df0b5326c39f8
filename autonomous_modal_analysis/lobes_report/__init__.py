"""What people see of stability lobes, and the files they leave."""

from autonomous_modal_analysis.lobes_report.files import FILES, lobes_json, lobes_table, save_lobes
from autonomous_modal_analysis.lobes_report.terminal_table import show_lobes

__all__ = ['FILES', 'lobes_json', 'lobes_table', 'save_lobes', 'show_lobes']
