"""Files as bytes: what is asked of one before it is read, and how memory stays bounded.

In come paths of any size and content; out go refusals with the reason, pages given back once read,
and arrays that are mapped instead of held.
"""

from modal_recordings.disk.file_size import check_size
from modal_recordings.disk.read_pages import ReadPages
from modal_recordings.disk.spooled import spooled
from modal_recordings.disk.unreadable import unreadable_bag, unreadable_database, unreadable_npy
from modal_recordings.disk.zstd_file import check_unpacked_size

__all__ = [
    'ReadPages',
    'check_size',
    'check_unpacked_size',
    'spooled',
    'unreadable_bag',
    'unreadable_database',
    'unreadable_npy',
]
