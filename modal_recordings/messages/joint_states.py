"""Joint states out of serialised messages.

A robot's joint states are all alike but for their stamps and their numbers: a batch of them is one
strided view.  Others are decoded one by one.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import MessageError
from modal_core.measurements import JointSamples, Measurement
from modal_recordings.messages.batch import DecodedBatch, one_by_one
from modal_recordings.messages.cdr import decode_stamps, HeaderFormat, ROS1
from modal_recordings.messages.cursor import Cursor

MOST_JOINTS = 256


def decode_joint_states(raws: Sequence[bytes], topic: str, header: HeaderFormat) -> DecodedBatch:
    """Decode a batch of JointState messages of one topic.

    Parameters
    ----------
    raws : sequence of bytes
        In order of arrival.
    topic : str
        For error messages.
    header : HeaderFormat
        How the headers are serialised.

    Returns
    -------
    DecodedBatch
        One :class:`JointSamples` per run of messages with the same joints.
    """
    ros1 = header is ROS1
    alike = _alike(raws, topic, header)
    if alike is not None:
        return DecodedBatch((alike,))
    batch = one_by_one(raws, lambda raw: decode_joint_state(Cursor(raw, topic, ros1=ros1)))
    return DecodedBatch(join_joint_samples(batch.measurements), batch.refused)


def _alike(raws: Sequence[bytes], topic: str, header: HeaderFormat) -> JointSamples | None:
    """Return what messages say that differ in stamps and numbers only; None of others."""
    if len(raws) < 2 or len({len(raw) for raw in raws}) > 1:
        return None
    try:
        cursor = Cursor(raws[0], topic, ros1=header is ROS1)
        names = decode_joint_state(cursor).joint_names
    except MessageError:
        return None
    places = cursor.places
    table = np.frombuffer(b''.join(raws), dtype=np.uint8).reshape(len(raws), -1)
    same = np.ones(table.shape[1], dtype=bool)
    # ROS 1 counts its messages before the stamp.
    same[0 if header is ROS1 else header.start : header.start + 8] = False
    for place in places:
        same[place] = False
    stamps, good = decode_stamps(table, header)
    if not good.all() or np.any(table[:, same] != table[0, same]):
        return None
    position, velocity, effort = (
        np.ascontiguousarray(table[:, place]).view('<f8').astype(np.float64)
        if place.stop > place.start
        else np.full((len(table), len(names)), np.nan)
        for place in places
    )
    if not np.isfinite(position).all():
        return None
    return JointSamples(stamps, names, position, velocity, effort)


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
