"""Joint states decoded together say what they say one by one."""

import numpy as np
import pytest

from modal_core.measurements import JointSamples
from modal_recordings.messages import decode, encode, JOINT_STATE

NAMES = ('joint_1', 'joint_2', 'joint_3')
STAMPS = np.arange(8) * 4_000_000 + 1_700_000_000_999_000_000


def _raws(velocity: bool, names: tuple[str, ...] = NAMES) -> tuple[JointSamples, list[bytes]]:
    rng = np.random.default_rng(3)
    position, speed = rng.normal(size=(2, len(STAMPS), len(names)))
    missing = np.full(position.shape, np.nan)
    sent = JointSamples(STAMPS, names, position, speed if velocity else missing, missing)
    return sent, [message.data for message in encode(sent, '/joint_states')]


@pytest.mark.parametrize('velocity', [False, True])
@pytest.mark.parametrize('ros1', [False, True])
def test_together_as_one_by_one(velocity: bool, ros1: bool) -> None:
    sent, raws = _raws(velocity, NAMES if not ros1 else ('joint_1',))
    if ros1:  # a counter instead of the encapsulation, no alignment
        raws = [_packed(raw, number) for number, raw in enumerate(raws)]
    (together,) = decode(raws, JOINT_STATE, '/joint_states', ros1=ros1).measurements
    singles = [decode([raw], JOINT_STATE, '/joint_states', ros1=ros1) for raw in raws]
    for field in ('stamp_ns', 'position', 'velocity', 'effort'):
        single = np.concatenate([getattr(item.measurements[0], field) for item in singles])
        np.testing.assert_array_equal(getattr(together, field), single)
        np.testing.assert_array_equal(getattr(together, field), getattr(sent, field))
    assert together.joint_names == sent.joint_names


def _packed(raw: bytes, number: int) -> bytes:
    """Return a message of one joint as ROS 1 serialises it."""
    text = raw[12:16] + raw[16:17]
    names = raw[20:24] + raw[24:28] + raw[28:36]
    rest, parts = raw[36:], [number.to_bytes(4, 'little'), raw[4:12], text, names]
    position = 0
    for _ in range(3):
        count = int.from_bytes(rest[position : position + 4], 'little')
        parts.append(rest[position : position + 4])
        position += 4
        if count:
            position += -(36 - 4 + position) % 8
            parts.append(rest[position : position + 8 * count])
            position += 8 * count
    return b''.join(parts)


def test_a_broken_one_is_refused_alone() -> None:
    sent, raws = _raws(velocity=True)
    bad = bytearray(raws[3])
    bad[8:12] = (2_000_000_000).to_bytes(4, 'little')
    not_finite = bytearray(raws[5])
    first = raws[5].index(np.float64(sent.position[5, 0]).tobytes())
    not_finite[first : first + 8] = np.float64(np.nan).tobytes()
    raws[3], raws[5] = bytes(bad), bytes(not_finite)
    found = decode(raws, JOINT_STATE, '/joint_states')
    (kept,) = found.measurements
    np.testing.assert_array_equal(kept.position, np.delete(sent.position, [3, 5], axis=0))
    assert ['stamp' in str(error) for error in found.refused] == [True, False]


def test_other_joints_of_equal_length_are_a_run_of_their_own() -> None:
    sent, raws = _raws(velocity=False)
    _, others = _raws(velocity=False, names=('joint_1', 'joint_2', 'joint_9'))
    found = decode([*raws[:4], *others[4:]], JOINT_STATE, '/joint_states').measurements
    assert [item.joint_names[-1] for item in found] == ['joint_3', 'joint_9']
    np.testing.assert_array_equal(found[0].position, sent.position[:4])
