"""What the controller says in one EgmRobot, checked as strict receivers check it."""

from dataclasses import dataclass
import math

from google.protobuf.message import DecodeError

from modal_core.errors import MessageError
from robot_bridge.egm.egm_messages import (
    EgmRobot,
    LARGEST_DATAGRAM_BYTES,
    MAX_JOINTS,
    MCI_ERROR,
    MCI_RUNNING,
    MCI_STOPPED,
    MESSAGE_TYPE_DATA,
    MOTORS_ON,
    RAPID_RUNNING,
)

Joints = tuple[float, ...]
MCI_NAMES = {MCI_ERROR: 'error', MCI_STOPPED: 'stopped', MCI_RUNNING: 'running'}
LARGEST_ANGLE_DEG = 1e5
MICROSECONDS = 1_000_000


@dataclass(frozen=True, slots=True)
class RobotFeedback:
    """One cycle of the controller.

    Parameters
    ----------
    seqno : int
        Running number; 0 begins a session.
    tm_ms : int [ms]
        Controller time, monotonic.
    joints_deg : (6,) tuple [deg]
        Measured motor-side axis angles, in the controller's convention.
    planned_deg : (6,) tuple [deg]
        Where the controller wants the axes.
    time_us : int [µs]
        Controller clock of the measurement.
    motors_on, rapid_running, converged : bool
        As reported.
    mci_state : int
        State of the session, an ``MCI_*`` constant.
    """

    seqno: int
    tm_ms: int
    joints_deg: Joints
    planned_deg: Joints
    time_us: int
    motors_on: bool
    mci_state: int
    rapid_running: bool
    converged: bool

    @property
    def mci_name(self) -> str:
        """State of the session in words."""
        return MCI_NAMES.get(self.mci_state, 'undefined')


def decode_robot(datagram: bytes) -> RobotFeedback:
    """Decode one datagram of the controller.

    Raises
    ------
    MessageError
        Not an EgmRobot, or a field that must be there is missing, or a number is not finite.
    """
    if len(datagram) > LARGEST_DATAGRAM_BYTES:
        raise MessageError('datagram too large', where='EgmRobot', found=len(datagram))
    try:
        message = EgmRobot.FromString(datagram)
    except DecodeError as error:
        raise MessageError(
            'not an EgmRobot', where='EgmRobot', found=f'{len(datagram)} bytes'
        ) from error
    if not message.IsInitialized():
        raise MessageError('required fields missing', where='EgmRobot')
    _require(message, ('header', 'feedBack', 'planned', 'motorState', 'mciState'), 'EgmRobot')
    _require(message, ('rapidExecState', 'mciConvergenceMet'), 'EgmRobot')
    _require(message.header, ('seqno', 'tm', 'mtype'), 'EgmRobot.header')
    if message.header.mtype != MESSAGE_TYPE_DATA:
        raise MessageError('wrong type', where='EgmRobot.header.mtype', found=message.header.mtype)
    clock = message.feedBack.time
    return RobotFeedback(
        seqno=message.header.seqno,
        tm_ms=message.header.tm,
        joints_deg=_position(message.feedBack, 'EgmRobot.feedBack'),
        planned_deg=_position(message.planned, 'EgmRobot.planned'),
        time_us=clock.sec * MICROSECONDS + clock.usec,
        motors_on=message.motorState.state == MOTORS_ON,
        mci_state=message.mciState.state,
        rapid_running=message.rapidExecState.state == RAPID_RUNNING,
        converged=message.mciConvergenceMet,
    )


def _require(message: EgmRobot, fields: tuple[str, ...], where: str) -> None:
    for field in fields:
        if not message.HasField(field):
            raise MessageError('field missing', where=f'{where}.{field}')


def _position(part: EgmRobot, where: str) -> Joints:
    """Return six finite angles of a part that also has its pose and time."""
    _require(part, ('joints', 'cartesian', 'time'), where)
    _require(part.cartesian, ('pos', 'orient'), f'{where}.cartesian')
    joints = tuple(part.joints.joints)
    if len(joints) != MAX_JOINTS:
        raise MessageError('wrong number of joints', where=where, found=len(joints), expected=6)
    if not all(math.isfinite(angle) and abs(angle) < LARGEST_ANGLE_DEG for angle in joints):
        raise MessageError('not an angle', where=where, found=joints)
    return joints
