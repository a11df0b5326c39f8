"""What each screen says.

In come results and states of the cell; out go updates, each a screen's content as plain values.
"""

from modal_dashboard.screens.board import Board, Update
from modal_dashboard.screens.cell_screens import BridgeNews, PlanNews, SILENT_S
from modal_dashboard.screens.checks import Check, Checks, CheckStep
from modal_dashboard.screens.diagram import Diagram, diagram_update, pole_table
from modal_dashboard.screens.run_log import RunLog
from modal_dashboard.screens.window_screens import shapes_update, window_updates

__all__ = [
    'SILENT_S',
    'Board',
    'BridgeNews',
    'Check',
    'CheckStep',
    'Checks',
    'Diagram',
    'PlanNews',
    'RunLog',
    'Update',
    'diagram_update',
    'pole_table',
    'shapes_update',
    'window_updates',
]
