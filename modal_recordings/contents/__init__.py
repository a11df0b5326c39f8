"""What a recording of messages holds.

In come its raw messages, once; out go counts, rates, gaps and jitter of its topics.
"""

from modal_recordings.contents.info import Gap, RecordingInfo, TopicSummary
from modal_recordings.contents.summary import summarise, why_unusable

__all__ = [
    'Gap',
    'RecordingInfo',
    'TopicSummary',
    'summarise',
    'why_unusable',
]
