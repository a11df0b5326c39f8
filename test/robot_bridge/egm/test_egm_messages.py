"""The wire format, byte by byte, against the proto2 encoding rules."""

import struct

from google.protobuf import descriptor_pool
import pytest

from modal_core.errors import MessageError
from robot_bridge.egm.egm_command import decode_sensor, encode_sensor
from robot_bridge.egm.egm_feedback import decode_robot
from robot_bridge.egm.egm_messages import EgmRobot, EgmSensor, PACKAGE


def varint(value):
    out = b''
    while value > 0x7F:
        out += bytes([value & 0x7F | 0x80])
        value >>= 7
    return out + bytes([value])


def field(number, wire, payload):
    return varint(number << 3 | wire) + payload


def block(number, payload):
    return field(number, 2, varint(len(payload)) + payload)


def double(number, value):
    return field(number, 1, struct.pack('<d', value))


def joints(values):
    return b''.join(double(1, value) for value in values)


def part(values):
    pos = double(1, 1.0) + double(2, 2.0) + double(3, 3.0)
    orient = double(1, 1.0) + double(2, 0.0) + double(3, 0.0) + double(4, 0.0)
    clock = field(1, 0, varint(1700000000)) + field(2, 0, varint(0))
    cartesian = block(1, pos) + block(2, orient)
    return block(1, joints(values)) + block(2, cartesian) + block(4, clock)


def robot_bytes(skip=(), seqno=0, angles=(0.0, 1.0, -2.0, 3.0, 4.0, 5.0)):
    header = field(1, 0, varint(seqno)) + field(2, 0, varint(7)) + field(3, 0, varint(2))
    parts = {
        1: block(1, header),
        2: block(2, part(angles)),
        3: block(3, part(angles)),
        4: block(4, field(1, 0, varint(1))),
        5: block(5, field(1, 0, varint(3))),
        6: field(6, 0, varint(0)),
        8: block(8, field(1, 0, varint(2))),
    }
    return b''.join(data for number, data in parts.items() if number not in skip)


def test_reply_is_the_bytes_of_the_proto2_rules():
    position, speed = [0.0, 1.5, -2.0, 3.0, 4.0, 5.0], [0.0] * 6
    header = field(1, 0, varint(0)) + field(2, 0, varint(300)) + field(3, 0, varint(3))
    expected = block(1, header)
    expected += block(2, block(1, joints(position))) + block(3, block(1, joints(speed)))
    assert encode_sensor(0, 300, position, speed) == expected


def test_zero_seqno_and_zero_angles_are_sent():
    decoded = decode_sensor(encode_sensor(0, 0, [0.0] * 6, [0.0] * 6))
    assert decoded.seqno == 0
    assert decoded.tm_ms == 0
    assert decoded.position_deg == (0.0,) * 6


def test_a_complete_robot_packet_is_read():
    feedback = decode_robot(robot_bytes())
    assert feedback.joints_deg == (0.0, 1.0, -2.0, 3.0, 4.0, 5.0)
    assert (feedback.seqno, feedback.tm_ms, feedback.time_us) == (0, 7, 1700000000_000000)
    assert feedback.motors_on
    assert feedback.rapid_running
    assert feedback.mci_name == 'running'


@pytest.mark.parametrize('number', [1, 2, 3, 4, 5, 6, 8])
def test_a_packet_without_any_required_part_is_refused(number):
    with pytest.raises(MessageError):
        decode_robot(robot_bytes(skip=(number,)))


@pytest.mark.parametrize('angles', [(0.0,) * 5, (0.0,) * 7, (float('nan'),) + (0.0,) * 5])
def test_wrong_or_not_finite_joints_are_refused(angles):
    with pytest.raises(MessageError):
        decode_robot(robot_bytes(angles=angles))


@pytest.mark.parametrize('data', [b'', b'\xff' * 40, b'junk', robot_bytes()[:-3], b'\x0a\xff\xff'])
def test_junk_is_refused_with_our_error(data):
    with pytest.raises(MessageError):
        decode_robot(data)


def test_unknown_fields_of_newer_controllers_are_tolerated():
    newer = robot_bytes() + block(12, field(1, 0, varint(1))) + block(14, double(1, 2.0))
    assert decode_robot(newer).motors_on


def test_extensions_of_robotware_6_and_7_are_tolerated_wherever_they_stand():
    # measuredForce has another type in 6 and 7; timeStamp is new in 7.16; external axes and
    # Euler angles come with the installation.
    euler = block(3, double(1, 0.0) + double(2, 90.0) + double(3, 0.0))
    pose = block(1, double(1, 1.0) + double(2, 2.0) + double(3, 3.0))
    pose += block(2, double(1, 1.0) + double(2, 0.0) + double(3, 0.0) + double(4, 0.0)) + euler
    clock = field(1, 0, varint(1)) + field(2, 0, varint(4032))
    values = joints((1.0, 2.0, 3.0, 4.0, 5.0, 6.0))
    part_7 = block(1, values) + block(2, pose) + block(3, joints((100.0,))) + block(4, clock)
    part_7 += block(5, clock)
    force_6 = block(9, joints((1.0,) * 6))
    force_7 = block(9, field(1, 0, varint(1)) + joints((1.0,) * 6))
    for force in (force_6, force_7):
        message = robot_bytes(skip=(2, 3)) + block(2, part_7) + block(3, part_7) + force
        message += double(10, 42.0) + field(11, 0, varint(3))
        message += block(13, double(1, 1.0)) + block(14, joints((0.0,) * 6))
        feedback = decode_robot(message)
        assert feedback.joints_deg == (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
        assert feedback.time_us == 1_004_032


@pytest.mark.parametrize('packed', [False, True])
def test_joints_packed_as_proto3_has_it_are_read_too(packed):
    angles = (0.0, 1.0, -2.0, 3.0, 4.0, 5.0)
    values = block(1, struct.pack('<6d', *angles)) if packed else joints(angles)
    cartesian = block(1, double(1, 1.0) + double(2, 2.0) + double(3, 3.0)) + block(
        2, double(1, 1.0) + double(2, 0.0) + double(3, 0.0) + double(4, 0.0)
    )
    clock = field(1, 0, varint(1)) + field(2, 0, varint(0))
    whole = block(1, values) + block(2, cartesian) + block(4, clock)
    message = robot_bytes(skip=(2, 3)) + block(2, whole) + block(3, whole)
    assert decode_robot(message).joints_deg == angles


@pytest.mark.parametrize('missing', [1, 2, 4])
@pytest.mark.parametrize('number', [2, 3])
def test_feedback_and_planned_must_be_complete(number, missing):
    whole = {
        1: block(1, joints((0.0,) * 6)),
        2: block(2, block(1, double(1, 1.0) + double(2, 2.0) + double(3, 3.0)) + block(
            2, double(1, 1.0) + double(2, 0.0) + double(3, 0.0) + double(4, 0.0)
        )),
        4: block(4, field(1, 0, varint(1)) + field(2, 0, varint(0))),
    }  # fmt: skip
    data = b''.join(value for key, value in whole.items() if key != missing)
    with pytest.raises(MessageError):
        decode_robot(robot_bytes(skip=(number,)) + block(number, data))


@pytest.mark.parametrize('pose', [b'', block(1, double(1, 1.0)), block(2, double(1, 1.0))])
def test_a_pose_needs_its_position_and_its_quaternion_whole(pose):
    clock = field(1, 0, varint(1)) + field(2, 0, varint(0))
    data = block(1, joints((0.0,) * 6)) + block(2, pose) + block(4, clock)
    with pytest.raises(MessageError):
        decode_robot(robot_bytes(skip=(2,)) + block(2, data))


@pytest.mark.parametrize('mtype', [0, 1, 3, 4, 9])
def test_only_data_is_taken_for_feedback(mtype):
    header = field(1, 0, varint(0)) + field(2, 0, varint(7)) + field(3, 0, varint(mtype))
    with pytest.raises(MessageError):
        decode_robot(robot_bytes(skip=(1,)) + block(1, header))


@pytest.mark.parametrize('number', [1, 2, 3])
def test_the_header_must_be_complete(number):
    fields = {1: varint(0), 2: varint(7), 3: varint(2)}
    header = b''.join(field(key, 0, value) for key, value in fields.items() if key != number)
    with pytest.raises(MessageError):
        decode_robot(robot_bytes(skip=(1,)) + block(1, header))


def test_an_undefined_program_state_is_not_running():
    undefined = robot_bytes(skip=(8,)) + block(8, field(1, 0, varint(0)))
    assert not decode_robot(undefined).rapid_running


def test_sequence_and_time_wrap_at_32_bits():
    decoded = decode_sensor(encode_sensor(2**32 + 1, 2**32 + 5, [0.0] * 6, None))
    assert (decoded.seqno, decoded.tm_ms, decoded.speed_deg_s) == (1, 5, None)
    highest = decode_sensor(encode_sensor(2**32 - 1, 2**32 - 1, [0.0] * 6, None))
    assert (highest.seqno, highest.tm_ms) == (2**32 - 1, 2**32 - 1)


def test_a_cartesian_speed_reference_is_no_joint_speed():
    header = field(1, 0, varint(0)) + field(2, 0, varint(7)) + field(3, 0, varint(3))
    data = block(1, header) + block(2, block(1, joints((0.0,) * 6)))
    cartesian = block(3, block(2, joints((10.0, 0.0, 0.0, 0.0, 0.0, 0.0))))
    external = block(3, block(3, joints((10.0,))))
    assert decode_sensor(data + cartesian).speed_deg_s is None
    assert decode_sensor(data + external).speed_deg_s is None


def test_names_stay_out_of_the_common_pool():
    with pytest.raises(KeyError):
        descriptor_pool.Default().FindMessageTypeByName(f'{PACKAGE}.EgmRobot')
    assert EgmRobot.DESCRIPTOR.file.pool is EgmSensor.DESCRIPTOR.file.pool
