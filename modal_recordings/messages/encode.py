"""Measurements to serialised ROS 2 messages, without ROS."""

import struct

import numpy as np
from numpy.typing import NDArray

from modal_core.measurements import (
    JointSamples,
    Measurement,
    NANOSECONDS_PER_SECOND,
    SampleBlock,
    StampedSamples,
)
from modal_core.units import ACCELERATION
from modal_recordings.messages.cdr import ACCEL, IMU
from modal_recordings.messages.decode import BLOCK, JOINT_STATE
from modal_recordings.messages.raw_message import RawMessage

ENCAPSULATION = b'\x00\x01\x00\x00'
NOT_REPORTED = -1.0


def encode(measurement: Measurement, topic: str) -> list[RawMessage]:
    """Serialise a measurement as the messages it came from.

    Parameters
    ----------
    measurement : Measurement
        Stamped samples with a gyroscope become Imu, those without AccelStamped; both need
        three columns.
    topic : str
        Where to.

    Returns
    -------
    list of RawMessage
        One per sample, or one per block.
    """
    if isinstance(measurement, SampleBlock):
        stamp = measurement.stamp_ns
        return [RawMessage(topic, BLOCK, stamp, encode_block(measurement))]
    if isinstance(measurement, JointSamples):
        return _joint_states(measurement, topic)
    return _vectors(measurement, topic)


def encode_block(block: SampleBlock, frame_id: str = '') -> bytes:
    """Serialise one AccelerationBlock."""
    buffer = bytearray(_header(block.stamp_ns, frame_id))
    _align(buffer, 8)
    buffer += struct.pack('<Qd', block.first_index, block.sample_rate_hz)
    _texts(buffer, _names_with_units(block))
    _align(buffer, 4)
    values = np.ascontiguousarray(block.acceleration, dtype='<f4')
    buffer += struct.pack('<II', len(values), values.size)
    buffer += values.tobytes()
    return bytes(buffer)


def _names_with_units(block: SampleBlock) -> tuple[str, ...]:
    """Return the names of channels, with the unit of what is no acceleration: ``belt [m/s]``."""
    units = block.units or (ACCELERATION,) * len(block.channel_names)
    return tuple(
        name if unit == ACCELERATION else f'{name} [{unit}]'
        for name, unit in zip(block.channel_names, units, strict=True)
    )


def _vectors(samples: StampedSamples, topic: str) -> list[RawMessage]:
    message_type = ACCEL if samples.angular_velocity is None else IMU
    if message_type == IMU:
        body = np.zeros((len(samples.stamp_ns), 37))
        body[:, 3] = 1.0
        body[:, 4] = NOT_REPORTED
        turn = np.asarray(samples.angular_velocity)
        body[:, 13:16] = np.nan_to_num(turn)
        # REP 145: what is not reported has covariance[0] = -1.
        body[:, 16] = np.where(np.isnan(turn).all(axis=1), NOT_REPORTED, 0.0)
        body[:, 25:28] = samples.acceleration
    else:
        body = np.zeros((len(samples.stamp_ns), 6))
        body[:, :3] = samples.acceleration
    rows = np.ascontiguousarray(body, dtype='<f8')
    messages = []
    for stamp, row in zip(samples.stamp_ns.tolist(), rows, strict=True):
        buffer = bytearray(_header(stamp, samples.frame_id))
        _align(buffer, 8)
        messages.append(RawMessage(topic, message_type, stamp, bytes(buffer) + row.tobytes()))
    return messages


def _joint_states(joints: JointSamples, topic: str) -> list[RawMessage]:
    messages = []
    for row, stamp in enumerate(joints.stamp_ns.tolist()):
        buffer = bytearray(_header(stamp, ''))
        _texts(buffer, joints.joint_names)
        for table in (joints.position, joints.velocity, joints.effort):
            _doubles(buffer, table[row] if len(table) else np.empty(0))
        messages.append(RawMessage(topic, JOINT_STATE, stamp, bytes(buffer)))
    return messages


def _doubles(buffer: bytearray, values: NDArray[np.float64]) -> None:
    if np.isnan(values).all():
        values = values[:0]
    _align(buffer, 4)
    buffer += struct.pack('<I', len(values))
    if len(values):
        _align(buffer, 8)
        buffer += np.ascontiguousarray(values, dtype='<f8').tobytes()


def _header(stamp_ns: int, frame_id: str) -> bytes:
    seconds, nanoseconds = divmod(stamp_ns, NANOSECONDS_PER_SECOND)
    text = frame_id.encode() + b'\x00'
    return ENCAPSULATION + struct.pack('<iII', seconds, nanoseconds, len(text)) + text


def _texts(buffer: bytearray, texts: tuple[str, ...]) -> None:
    _align(buffer, 4)
    buffer += struct.pack('<I', len(texts))
    for text in texts:
        data = text.encode() + b'\x00'
        _align(buffer, 4)
        buffer += struct.pack('<I', len(data)) + data


def _align(buffer: bytearray, size: int) -> None:
    buffer += bytes((4 - len(buffer)) % size)
