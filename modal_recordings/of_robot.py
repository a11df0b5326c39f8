"""A recording of columns, as the robot it was made on has it."""

from collections.abc import Sequence

from modal_core.channel import SensorLayout
from modal_core.layouts.channel_match import named_as_in
from modal_recordings.array_recording import ArrayRecording
from modal_recordings.open_recording import Recording
from modal_recordings.tables import joints_apart


def of_robot(recording: ArrayRecording, joint_names: Sequence[str]) -> ArrayRecording:
    """Return a recording whose columns of angles, speeds and torques are joint states.

    Parameters
    ----------
    recording : ArrayRecording
        As it was opened.
    joint_names : sequence of str
        Of the robot, in its order.

    Raises
    ------
    RecordingError
        Two sets of columns tell the same of the joints.
    """
    source = recording.read_from
    table, options, joints = joints_apart(
        recording.path, source.table, source.options, joint_names
    )
    return recording.again(table=table, options=options, joints=joints) if joints else recording


def called_as_in(layout: SensorLayout, recording: ArrayRecording) -> ArrayRecording:
    """Return a recording whose channels are called as a layout calls them.

    Names that mean no channel are taken in the layout's order beside joint states only: there the
    layout is that of the arm.  Elsewhere it may be of something else.
    """
    names, assumed = named_as_in(layout, recording.channel_names)
    if names == recording.channel_names or (assumed and recording.read_from.joints is None):
        return recording
    notes = (*recording.read_from.notes, assumed) if assumed else recording.read_from.notes
    return recording.again(names=names, notes=notes)


def as_on_arm(
    recording: Recording, joint_names: Sequence[str] = (), layout: SensorLayout | None = None
) -> Recording:
    """Return a recording of columns as the arm it was made on has it, another as it is.

    Parameters
    ----------
    recording : Recording
        As it was opened.
    joint_names : sequence of str
        Of the robot, in its order; none: it is not known.
    layout : SensorLayout or None
        Of its sensors.

    Raises
    ------
    RecordingError
        Two sets of columns tell the same of the joints.
    """
    if not isinstance(recording, ArrayRecording):
        return recording
    if joint_names:
        recording = of_robot(recording, joint_names)
    return recording if layout is None else called_as_in(layout, recording)
