"""Decode serialised ROS messages in batches, with numpy and without ROS.

The fixed-size sensor messages all begin with a header; its only variable part is the frame id.
Messages of one topic are therefore equally long, and a batch is one strided view.  Serialised
ROS 2 messages (CDR, little endian) align numbers to their size, counted from byte 4; ROS 1
messages are packed and their header begins with a sequence number.

References
----------
.. [1] OMG DDS Interoperability Wire Protocol 2.5, chapter 10 (serialised payload).
.. [2] http://wiki.ros.org/ROS/Connection%20Header and the roscpp serialisation traits.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import MessageError
from modal_core.measurements import Measurement, NANOSECONDS_PER_SECOND, StampedSamples
from modal_recordings.messages.batch import DecodedBatch

IMU = 'sensor_msgs/msg/Imu'
ACCEL = 'geometry_msgs/msg/AccelStamped'
ACCEL_WITH_COVARIANCE = 'geometry_msgs/msg/AccelWithCovarianceStamped'
LONGEST_FRAME_ID = 1024
NOT_REPORTED = -1.0
ENCAPSULATION_LITTLE_ENDIAN = 1


@dataclass(frozen=True, slots=True)
class HeaderFormat:
    """Where the parts of a serialised header lie.

    Parameters
    ----------
    start : int [bytes]
        First byte of the stamp.
    alignment : int [bytes]
        Of the numbers after the header, counted from ``origin``.
    origin : int [bytes]
        Where alignment is counted from.
    """

    start: int
    alignment: int
    origin: int

    def body(self, frame_length: int) -> int:
        """Return the first byte after a header whose frame id is this long."""
        end = self.start + 12 + frame_length
        return end + (self.origin - end) % self.alignment


CDR = HeaderFormat(start=4, alignment=8, origin=4)
ROS1 = HeaderFormat(start=4, alignment=1, origin=0)


@dataclass(frozen=True, slots=True)
class BodyFormat:
    """Where a sensor message keeps its vectors, in float64 after the header.

    Parameters
    ----------
    length : int
        Numbers in the body.
    acceleration, angular_velocity : int or None
        Index of the first of three numbers.
    """

    length: int
    acceleration: int
    angular_velocity: int | None = None


BODIES = {
    IMU: BodyFormat(length=37, acceleration=25, angular_velocity=13),
    ACCEL: BodyFormat(length=6, acceleration=0),
    ACCEL_WITH_COVARIANCE: BodyFormat(length=42, acceleration=0),
}


def decode_vectors(
    raws: Sequence[bytes], message_type: str, topic: str, header: HeaderFormat = CDR
) -> DecodedBatch:
    """Decode a batch of Imu, AccelStamped or AccelWithCovarianceStamped messages.

    Parameters
    ----------
    raws : sequence of bytes
        Serialised messages of one topic, in order of arrival.
    message_type : str
        Full ROS 2 type name.
    topic : str
        Becomes the source of the samples.
    header : HeaderFormat
        How the headers are serialised.

    Returns
    -------
    DecodedBatch
        One :class:`StampedSamples` per run of messages with the same frame id.
    """
    body = BODIES[message_type]
    measurements: list[Measurement] = []
    refused: list[MessageError] = []
    for length, run in groupby(raws, key=len):
        same = list(run)
        shortest = header.body(0) + 8 * body.length
        if not shortest <= length <= shortest + LONGEST_FRAME_ID:
            refused += [
                MessageError(
                    f'{message_type} of wrong length',
                    where=topic,
                    found=f'{length} bytes',
                    expected=f'{shortest} to {shortest + LONGEST_FRAME_ID}',
                )
            ] * len(same)
            continue
        table = np.frombuffer(b''.join(same), dtype=np.uint8).reshape(len(same), length)
        for rows in runs_of_equal_rows(table[:, header.start + 8 : header.start + 12]):
            found = _decode_table(table[rows], message_type, topic, header)
            measurements += found.measurements
            refused += found.refused
    return DecodedBatch(tuple(measurements), tuple(refused))


def _decode_table(
    table: NDArray[np.uint8], message_type: str, topic: str, header: HeaderFormat
) -> DecodedBatch:
    body = BODIES[message_type]
    frame_length = int(table[0, header.start + 8 : header.start + 12].view('<u4')[0])
    first = header.body(min(frame_length, 4 * LONGEST_FRAME_ID))
    if first + 8 * body.length != table.shape[1]:
        error = MessageError(
            f'{message_type} contradicts its own length',
            where=topic,
            found=f'{table.shape[1]} bytes with a frame id of {frame_length}',
            expected=f'{first + 8 * body.length} bytes',
        )
        return DecodedBatch(refused=(error,) * len(table))
    stamps, good = decode_stamps(table, header)
    refused = tuple(_refuse_stamp(topic, table[row], header) for row in np.flatnonzero(~good))
    frames = table[good, header.start + 12 : header.start + 12 + frame_length]
    numbers = np.ascontiguousarray(table[good, first:]).view('<f8')
    measurements = []
    for rows in runs_of_equal_rows(frames):
        acceleration = numbers[rows, body.acceleration : body.acceleration + 3]
        measurements.append(
            StampedSamples(
                source=topic,
                frame_id=text_of(frames[rows.start].tobytes()),
                stamp_ns=stamps[good][rows],
                acceleration=np.ascontiguousarray(acceleration, dtype=np.float64),
                angular_velocity=_reported(numbers[rows], body.angular_velocity),
            )
        )
    return DecodedBatch(tuple(measurements), refused)


def _reported(numbers: NDArray[np.float64], first: int | None) -> NDArray[np.float64] | None:
    # REP 145: covariance[0] = -1 says that the sensor does not report the quantity.
    if first is None or numbers[0, first + 3] == NOT_REPORTED:
        return None
    return np.ascontiguousarray(numbers[:, first : first + 3])


def decode_stamps(
    table: NDArray[np.uint8], header: HeaderFormat
) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Return header stamps [ns] of a table of messages, and which messages carry a valid one."""
    parts = np.ascontiguousarray(table[:, header.start : header.start + 8])
    seconds = parts.view('<i4')[:, 0].astype(np.int64)
    nanoseconds = parts.view('<u4')[:, 1].astype(np.int64)
    good = (seconds >= 0) & (nanoseconds < NANOSECONDS_PER_SECOND)
    if header is CDR:
        good &= (table[:, 0] == 0) & (table[:, 1] == ENCAPSULATION_LITTLE_ENDIAN)
    return seconds * NANOSECONDS_PER_SECOND + nanoseconds, good


def _refuse_stamp(topic: str, row: NDArray[np.uint8], header: HeaderFormat) -> MessageError:
    if header is CDR and tuple(row[:2]) != (0, ENCAPSULATION_LITTLE_ENDIAN):
        return MessageError(
            'unknown encapsulation', where=topic, found=row[:2].tobytes().hex(), expected='0001'
        )
    stamp = row[header.start : header.start + 8].view('<u4')
    return MessageError(
        'invalid stamp',
        where=f'{topic}: header.stamp',
        found=f'{int(stamp[0].view(np.int32))} s {int(stamp[1])} ns',
        expected='sec >= 0 and nanosec < 1000000000',
    )


def runs_of_equal_rows(table: NDArray[np.uint8]) -> list[slice]:
    """Return slices of consecutive equal rows."""
    if len(table) == 0:
        return []
    changes = np.flatnonzero(np.any(table[1:] != table[:-1], axis=1)) + 1
    edges = [0, *changes.tolist(), len(table)]
    return [slice(start, stop) for start, stop in pairwise(edges)]


def text_of(data: bytes) -> str:
    """Return a serialised string without its terminator, unreadable bytes replaced."""
    return data.rstrip(b'\x00').decode('utf-8', errors='replace')
