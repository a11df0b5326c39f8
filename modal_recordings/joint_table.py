"""Joint states in a table, beside its responses or alone."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

from modal_core.measurements import JointSamples, Measurement
from modal_recordings.array_recording import ArrayRecording
from modal_recordings.formats import read_arrays, READERS, tables_of
from modal_recordings.open_recording import ARRAY_READERS, check_place, kind_of
from modal_recordings.tables import (
    array_clock,
    array_columns,
    ArrayOptions,
    ArrayTable,
    joints_apart,
)

TABLES = (*ARRAY_READERS, *READERS)
"""Endings of files of columns."""


@dataclass(frozen=True)
class TableWithJoints:
    """What a file of columns tells of responses and joints.

    Parameters
    ----------
    responses : tuple of ArrayRecording
        One for every rate there is; may be none.
    joints : tuple of JointSamples
        May be none.
    """

    responses: tuple[ArrayRecording, ...]
    joints: tuple[JointSamples, ...]

    @property
    def notes(self) -> tuple[str, ...]:
        """What of the file takes no part, and what was assumed of units and times."""
        return tuple(dict.fromkeys(note for each in self.responses for note in each.notes))

    def measurements(self) -> Iterator[Measurement]:
        """Yield the responses in stretches, then the joint states."""
        return chain(*(each.measurements() for each in self.responses), self.joints)


def is_table(path: Path) -> bool:
    """Tell by its name whether a file is one of columns."""
    return path.suffix.lower() in TABLES


def open_with_joints(
    path: Path, joint_names: Sequence[str], options: ArrayOptions
) -> TableWithJoints:
    """Open a file of columns, some of which are angles, speeds or torques of joints.

    Parameters
    ----------
    path : Path
        Of any kind that has columns; arrays of two lengths need a time each.
    joint_names : sequence of str
        Of the robot, in its order.
    options : ArrayOptions
        What the file does not say itself.

    Raises
    ------
    RecordingError
        In one line: file, column, what was found and what was expected.

    See Also
    --------
    joint_columns_of : How columns of joints are called.
    """
    check_place(path)
    suffix = kind_of(path)
    tables = (
        (ARRAY_READERS[suffix](path),)
        if suffix in ARRAY_READERS
        else tables_of(path, read_arrays(path, suffix))
    )
    parts = [_parted(path, table, joint_names, options) for table in tables]
    return TableWithJoints(
        tuple(one for one, _ in parts if one is not None),
        tuple(two for _, two in parts if two is not None),
    )


def _parted(
    path: Path, table: ArrayTable, joint_names: Sequence[str], options: ArrayOptions
) -> tuple[ArrayRecording | None, JointSamples | None]:
    """Return the responses of a table, and its joint states."""
    rest, options, joints = joints_apart(path, table, options, joint_names)
    if joints is None:
        return ArrayRecording(path, table, options), None
    columns = array_columns(path, rest, options, may_have_none=True)
    if not columns.channels:
        clock = array_clock(path, rest, columns, options)
        return None, joints.samples(clock.row_stamps_ns(len(table.values)))
    responses = ArrayRecording(path, rest, options)
    return responses, joints.samples(responses.row_stamps_ns())
