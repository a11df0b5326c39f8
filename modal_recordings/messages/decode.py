"""Serialised messages to measurements, by message type; shared by recordings and nodes."""

from collections.abc import Sequence

from modal_core.errors import MessageError
from modal_core.measurements import SampleBlock
from modal_recordings.messages.batch import DecodedBatch, one_by_one
from modal_recordings.messages.cdr import BODIES, CDR, decode_vectors, ROS1
from modal_recordings.messages.cursor import Cursor
from modal_recordings.messages.joint_states import decode_joint_states

BLOCK = 'oma_msgs/msg/AccelerationBlock'
JOINT_STATE = 'sensor_msgs/msg/JointState'
USABLE_TYPES = (*BODIES, BLOCK, JOINT_STATE)
LARGEST_MESSAGE_BYTES = 16_000_000
LOWEST_BLOCK_RATE_HZ, HIGHEST_RATE_HZ = 0.5, 10_000_000.0
MOST_CHANNELS = 1024


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
    header = ROS1 if ros1 else CDR
    if message_type in BODIES:
        batch = decode_vectors(small, message_type, topic, header)
    elif message_type == BLOCK:
        batch = one_by_one(small, lambda raw: decode_block(Cursor(raw, topic, ros1=ros1)))
    else:
        batch = decode_joint_states(small, topic, header)
    return DecodedBatch(batch.measurements, (*refused, *batch.refused))


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
