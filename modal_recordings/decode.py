"""Serialised messages to measurements, by message type; shared by recordings and nodes."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import MessageError
from modal_core.measurements import JointSamples, Measurement, SampleBlock
from modal_recordings.batch import DecodedBatch
from modal_recordings.cdr import BODIES, CDR, decode_vectors, ROS1
from modal_recordings.cursor import Cursor

BLOCK = 'oma_msgs/msg/AccelerationBlock'
JOINT_STATE = 'sensor_msgs/msg/JointState'
USABLE_TYPES = (*BODIES, BLOCK, JOINT_STATE)
LARGEST_MESSAGE_BYTES = 16_000_000
LOWEST_BLOCK_RATE_HZ, HIGHEST_RATE_HZ = 0.5, 10_000_000.0
MOST_CHANNELS = 1024
MOST_JOINTS = 256


def decode(
    raws: Sequence[bytes], message_type: str, topic: str, *, ros1: bool = False
) -> DecodedBatch:
    """Decode a batch of serialised messages of one topic.

    Parameters
    ----------
    raws : sequence of bytes
        In order of arrival.
    message_type : str
        One of :data:`USABLE_TYPES`.
    topic : str
        Becomes the source of the measurements.
    ros1 : bool
        Serialised as ROS 1 does.

    Returns
    -------
    DecodedBatch
        Good messages decoded; the others refused one by one.
    """
    small = [raw for raw in raws if len(raw) <= LARGEST_MESSAGE_BYTES]
    refused = [
        MessageError(
            'message too large',
            where=topic,
            found=f'{len(raw)} bytes',
            expected=f'at most {LARGEST_MESSAGE_BYTES}',
        )
        for raw in raws
        if len(raw) > LARGEST_MESSAGE_BYTES
    ]
    if message_type in BODIES:
        batch = decode_vectors(small, message_type, topic, ROS1 if ros1 else CDR)
    else:
        one = decode_block if message_type == BLOCK else decode_joint_state
        batch = _one_by_one(small, lambda raw: one(Cursor(raw, topic, ros1=ros1)))
    measurements = batch.measurements
    if message_type == JOINT_STATE:
        measurements = join_joint_samples(measurements)
    return DecodedBatch(measurements, (*refused, *batch.refused))


def _one_by_one(raws: Sequence[bytes], decode_one: object) -> DecodedBatch:
    measurements: list[Measurement] = []
    refused: list[MessageError] = []
    for raw in raws:
        try:
            measurements.append(decode_one(raw))  # type: ignore[operator]
        except MessageError as error:
            refused.append(error)
    return DecodedBatch(tuple(measurements), tuple(refused))


def decode_block(cursor: Cursor) -> SampleBlock:
    """Decode one AccelerationBlock and check its contract.

    Raises
    ------
    MessageError
        Naming the field, what was found and what was expected.
    """
    topic = cursor.where
    stamp_ns = cursor.stamp_ns()
    cursor.text()
    first_index = cursor.uint64()
    rate = cursor.float64()
    names = cursor.texts()
    n_samples = cursor.uint32()
    values = cursor.numbers('<f4')
    if not LOWEST_BLOCK_RATE_HZ <= rate <= HIGHEST_RATE_HZ:  # false for NaN
        raise MessageError(
            'invalid rate',
            where=f'{topic}: sample_rate_hz',
            found=rate,
            expected=f'{LOWEST_BLOCK_RATE_HZ:g} to {HIGHEST_RATE_HZ:g}',
        )
    if first_index >= 2**62:
        raise MessageError('invalid counter', where=f'{topic}: first_index', found=first_index)
    check_block_names(names, topic)
    if n_samples < 1 or n_samples * len(names) != len(values):
        raise MessageError(
            'length does not match the shape',
            where=f'{topic}: acceleration',
            found=f'{len(values)} values',
            expected=f'n_samples x channels = {n_samples} x {len(names)}',
        )
    return SampleBlock(
        source=topic,
        stamp_ns=stamp_ns,
        first_index=first_index,
        sample_rate_hz=rate,
        channel_names=names,
        acceleration=values.reshape(n_samples, len(names)),  # type: ignore[arg-type]
    )


def check_block_names(names: tuple[str, ...], topic: str) -> None:
    """Refuse channel names that are missing, empty, repeated or too many.

    Raises
    ------
    MessageError
        Naming the topic and the name.
    """
    where = f'{topic}: channel_names'
    if not 0 < len(names) <= MOST_CHANNELS:
        raise MessageError(
            'bad number of channels',
            where=where,
            found=len(names),
            expected=f'1 to {MOST_CHANNELS}',
        )
    if '' in names:
        raise MessageError('empty channel name', where=where)
    if len(set(names)) != len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise MessageError('channel named twice', where=where, found=twice)


def decode_joint_state(cursor: Cursor) -> JointSamples:
    """Decode one JointState and check its contract.

    Raises
    ------
    MessageError
        Naming the field, what was found and what was expected.
    """
    topic = cursor.where
    stamp_ns = cursor.stamp_ns()
    cursor.text()
    names = cursor.texts()
    position = _per_joint(cursor, names, 'position')
    velocity = _per_joint(cursor, names, 'velocity')
    effort = _per_joint(cursor, names, 'effort')
    if not 0 < len(names) <= MOST_JOINTS:
        raise MessageError(
            'bad number of joints',
            where=f'{topic}: name',
            found=len(names),
            expected=f'1 to {MOST_JOINTS}',
        )
    if len(set(names)) != len(names):
        raise MessageError('joint named twice', where=f'{topic}: name', found=', '.join(names))
    if not np.isfinite(position).all():
        raise MessageError('missing or not finite', where=f'{topic}: position')
    return JointSamples(
        stamp_ns=np.array([stamp_ns], dtype=np.int64),
        joint_names=names,
        position=position,
        velocity=velocity,
        effort=effort,
    )


def _per_joint(cursor: Cursor, names: tuple[str, ...], field: str) -> NDArray[np.float64]:
    values = cursor.numbers('<f8')
    if len(values) not in (0, len(names)):
        raise MessageError(
            'length does not match the joints',
            where=f'{cursor.where}: {field}',
            found=len(values),
            expected=f'0 or {len(names)}',
        )
    if len(values) == 0:
        return np.full((1, len(names)), np.nan)
    return values.astype(np.float64).reshape(1, -1)


def join_joint_samples(measurements: Sequence[Measurement]) -> tuple[Measurement, ...]:
    """Join consecutive joint samples with the same joints into one."""
    joined: list[Measurement] = []
    run: list[JointSamples] = []
    for measurement in (*measurements, None):
        if isinstance(measurement, JointSamples) and (
            not run or measurement.joint_names == run[0].joint_names
        ):
            run.append(measurement)
            continue
        if run:
            joined.append(_concatenate(run))
        run = [measurement] if isinstance(measurement, JointSamples) else []
    if run:
        joined.append(_concatenate(run))
    return tuple(joined)


def _concatenate(run: Sequence[JointSamples]) -> JointSamples:
    return JointSamples(
        stamp_ns=np.concatenate([part.stamp_ns for part in run]),
        joint_names=run[0].joint_names,
        position=np.concatenate([part.position for part in run]),
        velocity=np.concatenate([part.velocity for part in run]),
        effort=np.concatenate([part.effort for part in run]),
    )
