"""Who may move the arm, when, and what stops it.

In come judged feedback and an operator's requests; out go references, or none, and a state that
tells the reason. Following, pace and lateness are watched on the way.
"""

from robot_bridge.operator.flow_base import AWAY
from robot_bridge.operator.flow_settings import check_fraction, FlowSettings, FlowState
from robot_bridge.operator.operator_flow import OperatorFlow
from robot_bridge.operator.stream_flow import StreamFlow

__all__ = ['AWAY', 'FlowSettings', 'FlowState', 'OperatorFlow', 'StreamFlow', 'check_fraction']
