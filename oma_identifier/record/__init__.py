"""A record as one: its samples kept in bounded memory, and what its windows say together.

In come identified windows, one after the other; out go the modes of the record: of its samples as
one stretch (or several between gaps), and of the windows where modes vary, or where the samples
are too many to keep.
"""

from oma_identifier.record.whole_record import SHORT_WINDOWS, TakenWindow, WholeRecord
from oma_identifier.record.window_length import needed_window_s, too_slow

__all__ = [
    'SHORT_WINDOWS',
    'TakenWindow',
    'WholeRecord',
    'needed_window_s',
    'too_slow',
]
