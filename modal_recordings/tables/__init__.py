"""Arrays of columns, wherever they come from.

In come values with headings and options; out go which columns are responses, times, counters or
joint states, in which unit, and when each row was taken.
"""

from modal_recordings.tables.array_clock import array_clock
from modal_recordings.tables.array_columns import (
    array_columns,
    ArrayColumns,
    LEAVE_OUT,
    without_columns,
)
from modal_recordings.tables.array_options import (
    Advice,
    array_options,
    ArrayOptions,
    checked_names,
    checked_rate,
    FIELDS,
)
from modal_recordings.tables.array_table import array_table, ArrayTable, MOST_COLUMNS, read_npy
from modal_recordings.tables.heading import Heading, heading_of
from modal_recordings.tables.joint_headings import is_of_joints
from modal_recordings.tables.joint_rows import JointRows, joints_apart
from modal_recordings.tables.row_period import row_period_s
from modal_recordings.tables.time_text import (
    date_order,
    DateOrder,
    has_date,
    is_time_text,
    seconds_of,
)

__all__ = [
    'FIELDS',
    'LEAVE_OUT',
    'MOST_COLUMNS',
    'Advice',
    'ArrayColumns',
    'ArrayOptions',
    'ArrayTable',
    'DateOrder',
    'Heading',
    'JointRows',
    'array_clock',
    'array_columns',
    'array_options',
    'array_table',
    'checked_names',
    'checked_rate',
    'date_order',
    'has_date',
    'heading_of',
    'is_of_joints',
    'is_time_text',
    'joints_apart',
    'read_npy',
    'row_period_s',
    'seconds_of',
    'without_columns',
]
