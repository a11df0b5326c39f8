"""The spindle's speed as a message of a recording."""

import struct

from modal_recordings.messages import ENCAPSULATION, RawMessage

SPEED_TOPIC = '/spindle_speed_rpm'
SPEED_TYPE = 'std_msgs/msg/Float64'


def speed_message(speed_rpm: float, time_ns: int) -> RawMessage:
    """Return a Float64 [rpm], stamped by the time it is recorded at."""
    return RawMessage(
        SPEED_TOPIC, SPEED_TYPE, time_ns, ENCAPSULATION + struct.pack('<d', speed_rpm)
    )
