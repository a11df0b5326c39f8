"""Serialised ROS messages without ROS.

In come raw messages of any type; out go measurements by type, and messages of measurements.
"""

from modal_recordings.messages.attachment import (
    as_text,
    attached,
    attached_layout,
    attached_software,
    Attachment,
    LARGEST_BYTES,
    media_type,
    save_attachments,
    SOFTWARE,
)
from modal_recordings.messages.by_stamp import first_stamp, log_times_mislead, side_by_side
from modal_recordings.messages.cdr import ACCEL, ACCEL_WITH_COVARIANCE, IMU
from modal_recordings.messages.decode import (
    BLOCK,
    decode,
    JOINT_STATE,
    LOWEST_BLOCK_RATE_HZ,
    USABLE_TYPES,
)
from modal_recordings.messages.encode import ENCAPSULATION, encode
from modal_recordings.messages.raw_message import (
    bunched,
    Kept,
    MessageFile,
    one_by_one,
    RawMessage,
    TopicEntry,
)
from modal_recordings.messages.schemas import (
    definition,
    differing_field,
    message_fields,
    typestore,
)
from modal_recordings.messages.small_blocks import most_rows, small_blocks

__all__ = [
    'ACCEL',
    'ACCEL_WITH_COVARIANCE',
    'BLOCK',
    'ENCAPSULATION',
    'IMU',
    'JOINT_STATE',
    'LARGEST_BYTES',
    'LOWEST_BLOCK_RATE_HZ',
    'SOFTWARE',
    'USABLE_TYPES',
    'Attachment',
    'Kept',
    'MessageFile',
    'RawMessage',
    'TopicEntry',
    'as_text',
    'attached',
    'attached_layout',
    'attached_software',
    'bunched',
    'decode',
    'definition',
    'differing_field',
    'encode',
    'first_stamp',
    'log_times_mislead',
    'media_type',
    'message_fields',
    'most_rows',
    'one_by_one',
    'save_attachments',
    'side_by_side',
    'small_blocks',
    'typestore',
]
