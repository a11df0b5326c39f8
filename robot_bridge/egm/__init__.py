"""Externally Guided Motion of ABB: the packets, and the link they come and go by.

In come the controller's UDP packets; out go feedback that was judged (session, order, clock,
jumps) and the replies. The messages are those of ABB's egm.proto.
"""

from robot_bridge.egm.egm_command import decode_sensor, SensorCommand
from robot_bridge.egm.egm_feedback import MICROSECONDS, RobotFeedback
from robot_bridge.egm.egm_link import Answer, EgmLink, Packet
from robot_bridge.egm.egm_messages import (
    EgmRobot,
    file_descriptor,
    MCI_ERROR,
    MCI_RUNNING,
    MCI_STOPPED,
    MESSAGE_TYPE_DATA,
    PACKAGE,
    RAPID_RUNNING,
    RAPID_STOPPED,
    RAPID_UNDEFINED,
)
from robot_bridge.egm.reply_latency import ReplyLatency
from robot_bridge.egm.session_check import (
    Address,
    Judgement,
    SessionCheck,
    SessionLimits,
    Verdict,
)
from robot_bridge.egm.six_axes import check_six_axes

__all__ = [
    'MCI_ERROR',
    'MCI_RUNNING',
    'MCI_STOPPED',
    'MESSAGE_TYPE_DATA',
    'MICROSECONDS',
    'PACKAGE',
    'RAPID_RUNNING',
    'RAPID_STOPPED',
    'RAPID_UNDEFINED',
    'Address',
    'Answer',
    'EgmLink',
    'EgmRobot',
    'Judgement',
    'Packet',
    'ReplyLatency',
    'RobotFeedback',
    'SensorCommand',
    'SessionCheck',
    'SessionLimits',
    'Verdict',
    'check_six_axes',
    'decode_sensor',
    'file_descriptor',
]
