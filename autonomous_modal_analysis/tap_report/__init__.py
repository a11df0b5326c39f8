"""What people see of a tap test, and the files it leaves."""

from autonomous_modal_analysis.tap_report.files import FILES, save_tap_test, tap_test_json
from autonomous_modal_analysis.tap_report.terminal_table import show_tap_test

__all__ = ['FILES', 'save_tap_test', 'show_tap_test', 'tap_test_json']
