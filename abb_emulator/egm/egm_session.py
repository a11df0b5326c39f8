"""One EGM session of the controller: what it says each cycle and what it hears."""

from dataclasses import dataclass
from enum import IntEnum
import math

import numpy as np
from numpy.typing import NDArray
import pinocchio as pin

from abb_emulator.egm.guidance_law import GuidanceSettings
from modal_core.errors import MessageError
from robot_bridge.egm import (
    decode_sensor,
    EgmRobot,
    MCI_ERROR,
    MCI_RUNNING,
    MCI_STOPPED,
    MESSAGE_TYPE_DATA,
    SensorCommand,
)
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]
UINT32 = 1 << 32
MICROSECONDS = 1_000_000
MM = 1000.0


class Phase(IntEnum):
    """What the session does; the numbers are mciState on the wire."""

    ERROR = MCI_ERROR
    STOPPED = MCI_STOPPED
    RUNNING = MCI_RUNNING


@dataclass(frozen=True, slots=True)
class Status:
    """What one message reports.

    Parameters
    ----------
    measured_deg, planned_deg : (6,) array [deg]
        Controller axis angles.
    time_s : float [s]
        Controller clock.
    motors_on, converged : bool
        As they are.
    rapid_state : int
        A ``RAPID_*`` constant.
    utilization : float [%]
        Of the speed limits.
    """

    measured_deg: Array
    planned_deg: Array
    time_s: float
    motors_on: bool
    converged: bool
    rapid_state: int
    utilization: float = 0.0


class EgmSession:
    """A session from EGMSetupUC to EGMReset.

    Parameters
    ----------
    settings : GuidanceSettings
        As set up.
    model : FlexibleJointModel
        For the Cartesian pose of the flange.
    """

    def __init__(self, settings: GuidanceSettings, model: FlexibleJointModel) -> None:
        self.settings = settings
        self.phase = Phase.STOPPED
        self.sending = False
        self.heard = False
        self.silence_s = 0.0
        self.n_bad = 0
        self.n_odd = 0
        self._model = model
        self._data = model.robot.model.createData()
        self._frame = model.robot.tip_frame
        self._seqno = 0
        self._last_seqno: int | None = None

    def message(self, status: Status) -> bytes:
        """Return the next datagram to send."""
        message = EgmRobot()
        header = message.header
        header.seqno = self._seqno % UINT32
        header.tm = round(status.time_s * 1000.0) % UINT32
        header.mtype = MESSAGE_TYPE_DATA
        self._seqno += 1
        for part, angles in (
            (message.feedBack, status.measured_deg),
            (message.planned, status.planned_deg),
        ):
            part.joints.joints.extend(angles.tolist())
            self._pose(part.cartesian, angles)
            microseconds = round(status.time_s * MICROSECONDS)
            part.time.sec, part.time.usec = divmod(microseconds, MICROSECONDS)
        message.motorState.state = 1 if status.motors_on else 2
        message.mciState.state = int(self.phase)
        message.mciConvergenceMet = status.converged
        message.rapidExecState.state = status.rapid_state
        message.utilizationRate = status.utilization
        return bytes(message.SerializeToString())

    def begin_again(self) -> None:
        """Count from 0 again, and expect the sensor to do as it likes."""
        self._seqno, self._last_seqno = 0, None

    def hear(self, datagram: bytes) -> SensorCommand | None:
        """Take one datagram; None when it is not one the controller understands."""
        try:
            command = decode_sensor(datagram)
        except MessageError:
            self.n_bad += 1
            return None
        expected = None if self._last_seqno is None else (self._last_seqno + 1) % UINT32
        if command.seqno is None or command.tm_ms is None or not command.correction:
            self.n_odd += 1
        elif expected is not None and command.seqno != expected:
            self.n_odd += 1
        self._last_seqno = command.seqno
        self.heard, self.silence_s = True, 0.0
        return command

    def _pose(self, pose: EgmRobot, angles_deg: Array) -> None:
        robot = self._model.robot.model
        serial = self._model.axes.to_serial(np.radians(angles_deg))
        pin.forwardKinematics(robot, self._data, serial)
        place = pin.updateFramePlacement(robot, self._data, self._frame)
        pose.pos.x, pose.pos.y, pose.pos.z = (place.translation * MM).tolist()
        quaternion = pin.Quaternion(place.rotation)
        orient = pose.orient
        orient.u0, orient.u1, orient.u2, orient.u3 = (
            quaternion.w,
            quaternion.x,
            quaternion.y,
            quaternion.z,
        )
        euler = pose.euler
        euler.x, euler.y, euler.z = (
            math.degrees(a) for a in pin.rpy.matrixToRpy(place.rotation).tolist()
        )
