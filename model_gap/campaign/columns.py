"""A recording of a campaign that is a file of columns: responses and joint states by name."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import chain
from pathlib import Path

from modal_core.channel import SensorLayout
from modal_core.errors import RecordingError
from modal_core.layouts.channel_match import named_as_in
from modal_core.measurements import JointSamples, Measurement
from modal_core.words.named import named
from modal_recordings.joint_table import open_with_joints, TableWithJoints
from modal_recordings.tables import Advice, array_options
from model_gap.campaign.campaign_file import CampaignEntry

ADVICE = Advice(
    rate='a time column, or sample_rate_hz in campaign.yaml or the sidecar',
    columns='name all columns in campaign.yaml or the sidecar, as channels: ["time [s]", q1, ...,'
    ' elbow.x, "-"]; - leaves one out',
    unit='unit in campaign.yaml or the sidecar',
)


def read_columns(entry: CampaignEntry, joint_names: tuple[str, ...]) -> TableWithJoints:
    """Open the file of columns of an entry.

    Raises
    ------
    RecordingError
        What it is, what it lacks, and how to say what it does not say itself.
    """
    options = array_options(entry.path, **entry.stated)
    found = open_with_joints(entry.path, joint_names, replace(options, advice=ADVICE))
    if not found.joints and entry.joints is None:
        names = [name for each in found.responses for name in each.channel_names]
        raise RecordingError(
            'no joint angles among the columns: the motion is not known',
            where=str(entry.path),
            found=named(names),
            expected=f'one for every joint: {named(joint_names)}; or q1, q2, ... [rad] or [deg]',
            advice='angles in a file of their own: joints: FILE beside file: in campaign.yaml',
        )
    return found


def joints_beside(path: Path, joint_names: tuple[str, ...]) -> Iterator[JointSamples]:
    """Yield the joint states of a file that holds them beside a recording.

    Raises
    ------
    RecordingError
        It holds none.
    """
    options = array_options(path)
    found = open_with_joints(path, joint_names, replace(options, advice=ADVICE))
    if not found.joints:
        names = [name for each in found.responses for name in each.channel_names]
        raise RecordingError(
            'no joint angles among the columns',
            where=str(path),
            found=named(names),
            expected=f'one for every joint: {named(joint_names)}; or q1, q2, ...',
        )
    yield from found.joints


def in_order_of(
    layout: SensorLayout, found: TableWithJoints
) -> tuple[Iterable[Measurement], tuple[str, ...]]:
    """Return measurements of columns, and what was assumed of their names.

    Columns none of which is called as a channel are those of the layout, in its order, if they
    are as many.
    """
    if len(found.responses) != 1:
        return found.measurements(), ()
    names, assumed = named_as_in(layout, found.responses[0].channel_names)
    if not assumed:
        return found.measurements(), ()
    renamed = (
        item if isinstance(item, JointSamples) else replace(item, channel_names=names)
        for item in found.responses[0].measurements()
    )
    return chain(renamed, found.joints), (assumed,)
