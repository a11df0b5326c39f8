"""Recordings in and out: rosbag2, MCAP, ROS 1 bags and plain arrays, without ROS.

``open_recording(path)`` gives a recording with ``info()`` and ``measurements()``;
``RecordingWriter`` writes MCAP; ``to_mcap`` converts.
"""

from modal_recordings.array_in_memory import array_recording
from modal_recordings.array_recording import ArrayRecording
from modal_recordings.containers import RecordingWriter
from modal_recordings.contents import Gap, RecordingInfo, TopicSummary
from modal_recordings.convert import to_mcap
from modal_recordings.message_recording import MessageRecording
from modal_recordings.messages import Attachment, decode, USABLE_TYPES
from modal_recordings.open_recording import open_recording, Recording

__all__ = [
    'USABLE_TYPES',
    'ArrayRecording',
    'Attachment',
    'Gap',
    'MessageRecording',
    'Recording',
    'RecordingInfo',
    'RecordingWriter',
    'TopicSummary',
    'array_recording',
    'decode',
    'open_recording',
    'to_mcap',
]
