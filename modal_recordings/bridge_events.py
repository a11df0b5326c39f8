"""What a bridge wrote into its packet log about itself: every state, and why."""

from collections import deque

from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_recordings.message_recording import MessageRecording
from modal_recordings.messages import ENCAPSULATION

EVENT_TOPIC, EVENT_TYPE = 'robot_bridge/events', 'std_msgs/msg/String'
LAST_EVENTS = 5
LENGTH_BYTES = 4


def last_events(recording: MessageRecording) -> tuple[str, ...]:
    """Return the last states of the bridge in a packet log, timed from its end; else nothing."""
    if EVENT_TOPIC not in {entry.name for entry in recording.entries}:
        return ()
    end_ns, events = 0, deque[tuple[int, str]](maxlen=LAST_EVENTS)
    for message in recording.file.messages():
        end_ns = max(end_ns, message.log_time_ns)
        if message.topic == EVENT_TOPIC:
            text = message.data[len(ENCAPSULATION) + LENGTH_BYTES :].rstrip(b'\x00')
            events.append((message.log_time_ns, text.decode(errors='replace')))
    return tuple(
        f'{(end_ns - time_ns) / NANOSECONDS_PER_SECOND:.3f} s before the end: {text}'
        for time_ns, text in events
    )
