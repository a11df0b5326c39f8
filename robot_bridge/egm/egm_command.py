"""What the sensor side asks for in one EgmSensor."""

from collections.abc import Sequence
from dataclasses import dataclass

from google.protobuf.message import DecodeError

from modal_core.errors import MessageError
from robot_bridge.egm.egm_feedback import LARGEST_ANGLE_DEG
from robot_bridge.egm.egm_messages import EgmSensor, MAX_JOINTS, MESSAGE_TYPE_CORRECTION

Joints = tuple[float, ...]
UINT32 = 1 << 32


@dataclass(frozen=True, slots=True)
class SensorCommand:
    """One reply.

    Parameters
    ----------
    position_deg : (6,) tuple [deg] or None
        Axis angles wanted; None when the message has none.
    speed_deg_s : (6,) tuple [deg/s] or None
        Speed reference, None when the message has none.
    seqno, tm_ms : int or None
        As sent, None when absent.
    correction : bool
        The header says CORRECTION, as it should.
    """

    position_deg: Joints | None
    speed_deg_s: Joints | None = None
    seqno: int | None = None
    tm_ms: int | None = None
    correction: bool = True


def encode_sensor(
    seqno: int, tm_ms: int, position_deg: Sequence[float], speed_deg_s: Sequence[float] | None
) -> bytes:
    """Return the datagram of one reply; numbers must be finite."""
    message = EgmSensor()
    header = message.header
    header.seqno = seqno % UINT32
    header.tm = tm_ms % UINT32
    header.mtype = MESSAGE_TYPE_CORRECTION
    message.planned.joints.joints.extend(position_deg)
    if speed_deg_s is not None:
        message.speedRef.joints.joints.extend(speed_deg_s)
    return bytes(message.SerializeToString())


def decode_sensor(datagram: bytes) -> SensorCommand:
    """Decode one reply as the controller reads it.

    Raises
    ------
    MessageError
        Not an EgmSensor, a wrong number of joints, or a number that is not finite.
    """
    try:
        message = EgmSensor.FromString(datagram)
    except DecodeError as error:
        raise MessageError('not an EgmSensor', found=f'{len(datagram)} bytes') from error
    if not message.IsInitialized() or not message.HasField('header'):
        raise MessageError('required fields missing', where='EgmSensor')
    header = message.header
    return SensorCommand(
        position_deg=_joints(message.planned.joints.joints, 'planned'),
        speed_deg_s=_joints(message.speedRef.joints.joints, 'speedRef'),
        seqno=header.seqno if header.HasField('seqno') else None,
        tm_ms=header.tm if header.HasField('tm') else None,
        correction=header.mtype == MESSAGE_TYPE_CORRECTION,
    )


def _joints(values: Sequence[float], field: str) -> Joints | None:
    joints = tuple(values)
    if not joints:
        return None
    if len(joints) != MAX_JOINTS:
        raise MessageError(
            'wrong number of joints', where=f'EgmSensor.{field}', found=len(joints), expected=6
        )
    # Neither NaN nor infinite, nor what overflows in a control law.
    if not all(abs(value) <= LARGEST_ANGLE_DEG for value in joints):
        raise MessageError('not finite or too large', where=f'EgmSensor.{field}', found=joints)
    return joints
