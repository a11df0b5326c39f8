"""Files that hold messages: MCAP, rosbag2, ROS 1 bags.

In come files, damaged or not; out go raw messages in their order, attachments, and what was lost.
What is written stays readable whatever stops it.
"""

from modal_recordings.containers.bag_file import BagFile
from modal_recordings.containers.folder import open_folder
from modal_recordings.containers.mcap_file import McapFile
from modal_recordings.containers.writer import RecordingWriter

__all__ = [
    'BagFile',
    'McapFile',
    'RecordingWriter',
    'open_folder',
]
