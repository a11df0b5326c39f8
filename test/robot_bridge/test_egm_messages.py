"""The wire format, byte by byte, against the proto2 encoding rules."""

import struct

from google.protobuf import descriptor_pool
import pytest

from modal_core.errors import MessageError
from robot_bridge.egm_command import decode_sensor, encode_sensor
from robot_bridge.egm_feedback import decode_robot
from robot_bridge.egm_messages import EgmRobot, EgmSensor, PACKAGE


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


def test_names_stay_out_of_the_common_pool():
    with pytest.raises(KeyError):
        descriptor_pool.Default().FindMessageTypeByName(f'{PACKAGE}.EgmRobot')
    assert EgmRobot.DESCRIPTOR.file.pool is EgmSensor.DESCRIPTOR.file.pool
