"""Write any recording as MCAP, so that it can be replayed through live nodes."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from modal_core.errors import RecordingError
from modal_core.measurements import JointSamples, Measurement, SampleBlock, StampedSamples
from modal_core.units import ACCELERATION
from modal_core.work.progress import Progress
from modal_recordings.array_recording import ArrayRecording
from modal_recordings.containers import RecordingWriter
from modal_recordings.messages import encode, RawMessage, small_blocks
from modal_recordings.open_recording import Recording

BLOCK_TOPIC = '/acceleration_block'
JOINT_TOPIC = '/joint_states'


def to_mcap(recording: Recording, path: str | Path, progress: Progress | None = None) -> Path:
    """Write a recording as MCAP, with the files it carries.

    A plain array with a rate becomes AccelerationBlock messages; one with a time column and
    three columns becomes one Imu message per row, on its own, perhaps irregular, times.

    Parameters
    ----------
    recording : Recording
        From :func:`open_recording`.
    path : path
        The .mcap file to write.
    progress : callable or None
        Told the seconds of data written so far.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    RecordingError
        It cannot be written, or a timed array has other than three columns.
    """
    if Path(path).suffix.lower() != '.mcap':
        raise RecordingError('not an .mcap name', where=path, found=Path(path).suffix or 'none')
    start_ns: int | None = None
    with RecordingWriter(path, attached=_attached(recording)) as writer:
        for message in _messages(recording):
            writer.write(message.topic, message.message_type, message.log_time_ns, message.data)
            if progress is not None:
                start_ns = message.log_time_ns if start_ns is None else start_ns
                progress((message.log_time_ns - start_ns) * 1e-9)
        return writer.close()


def array_messages(recording: ArrayRecording) -> Iterator[RawMessage]:
    """Yield a plain array as the messages a driver would have sent.

    Raises
    ------
    RecordingError
        A time column with other than three columns.
    """
    for measurement in recording.measurements():
        yield from _encode_array(recording, measurement)


def _attached(recording: Recording) -> dict[str, bytes]:
    """Return what a recording carries and can be read."""
    return {each.name: each.data for each in recording.attachments() if not each.problem}


def _messages(recording: Recording) -> Iterator[RawMessage]:
    if isinstance(recording, ArrayRecording):
        yield from array_messages(recording)
    elif recording.file.ros1:
        for measurement in recording.measurements():
            is_joints = isinstance(measurement, JointSamples)
            topic = JOINT_TOPIC if is_joints else measurement.source  # type: ignore[union-attr]
            yield from encode(measurement, topic)
    else:
        yield from recording.messages()


def _encode_array(recording: ArrayRecording, measurement: Measurement) -> list[RawMessage]:
    if isinstance(measurement, JointSamples):
        return encode(measurement, JOINT_TOPIC)
    if isinstance(measurement, SampleBlock):
        return [
            message for part in small_blocks(measurement) for message in encode(part, BLOCK_TOPIC)
        ]
    if not isinstance(measurement, StampedSamples) or measurement.acceleration.shape[1] != 3:
        raise RecordingError(
            'a time column needs three columns x, y, z to become Imu messages',
            where=recording.path,
            found=', '.join(recording.channel_names),
            advice='state the rate with --sample-rate-hz instead',
        )
    if set(measurement.units) - {ACCELERATION}:
        raise RecordingError(
            'only accelerations become Imu messages',
            where=recording.path,
            found=', '.join(sorted(set(measurement.units))),
            advice='state the rate with --sample-rate-hz instead',
        )
    return encode(
        StampedSamples(
            source=measurement.source,
            frame_id=measurement.source,
            stamp_ns=measurement.stamp_ns,
            acceleration=measurement.acceleration,
            angular_velocity=np.full_like(measurement.acceleration, np.nan),
        ),
        f'/imu/{_topic_word(recording.source)}',
    )


def _topic_word(name: str) -> str:
    word = ''.join(letter if letter.isascii() and letter.isalnum() else '_' for letter in name)
    return word.lower() if word[:1].isalpha() else f'sensor_{word.lower()}'
