"""What the controller refuses to do: ranges, speeds, and axes that do not follow."""

import numpy as np
from numpy.typing import NDArray
import pinocchio as pin

from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]
RANGE_SLACK_DEG = 1e-6


class Supervision:
    """Checks every next position of the axes.

    Parameters
    ----------
    model : FlexibleJointModel
        Ranges, speeds and kinematics.
    cycle_s : float [s]
        Controller cycle.
    speed_slack : float
        Factor on speed limits before it stops.
    following_error_deg : float [deg]
        Largest distance between command and motor.
    """

    def __init__(
        self,
        model: FlexibleJointModel,
        cycle_s: float,
        speed_slack: float,
        following_error_deg: float,
    ) -> None:
        limits = model.limits
        self._model, self._cycle_s, self._slack = model, cycle_s, speed_slack
        self._following_deg = following_error_deg
        self.top_speed_deg_s = np.asarray(np.degrees(limits.velocity))
        self._ranges = (
            ('axis', np.degrees(limits.controller_low), np.degrees(limits.controller_high)),
            ('coupled axis', np.degrees(limits.position_low), np.degrees(limits.position_high)),
        )
        self._data = model.robot.model.createData()
        self._frame = model.robot.tip_frame

    def range_fault(self, before: Array, after: Array) -> str:
        """Return which axis leaves its range; one outside already may come back."""
        axes = self._model.axes
        pairs = ((before, after), (axes.to_serial(before), axes.to_serial(after)))
        for (name, low, high), (old, new) in zip(self._ranges, pairs, strict=True):
            wrong = (new < low - RANGE_SLACK_DEG) & (new < old)
            wrong |= (new > high + RANGE_SLACK_DEG) & (new > old)
            if wrong.any():
                return f'{name} {int(np.argmax(wrong)) + 1} at its range'
        return ''

    def outside(self, angles_deg: Array) -> str:
        """Return which axis a place would leave outside its range."""
        pairs = zip(
            self._ranges, (angles_deg, self._model.axes.to_serial(angles_deg)), strict=True
        )
        for (name, low, high), angles in pairs:
            wrong = (angles < low - RANGE_SLACK_DEG) | (angles > high + RANGE_SLACK_DEG)
            if wrong.any():
                axis = int(np.argmax(wrong))
                return f'{name} {axis + 1} at {angles[axis]:.3f} deg'
        return ''

    def speed_fault(self, before: Array, after: Array, tool_speed_m_s: float) -> str:
        """Return what is too fast: an axis, or the flange beyond its limit [m/s]."""
        speed = np.abs(after - before) / self._cycle_s
        fast = speed > self.top_speed_deg_s * self._slack
        if fast.any():
            return f'axis {int(np.argmax(fast)) + 1} too fast'
        if np.isfinite(tool_speed_m_s) and speed.any():
            way = np.linalg.norm(self.flange_m(after) - self.flange_m(before))
            if way > tool_speed_m_s * self._slack * self._cycle_s:
                return f'flange faster than {1e3 * tool_speed_m_s:.0f} mm/s'
        return ''

    def following_fault(self, target: Array, measured: Array) -> str:
        """Return which axis does not follow."""
        away = np.abs(target - measured) > self._following_deg
        return f'axis {int(np.argmax(away)) + 1} does not follow' if away.any() else ''

    def flange_m(self, angles_deg: Array) -> Array:
        """Return where the flange is, (3,) [m]."""
        robot = self._model.robot.model
        serial = self._model.axes.to_serial(np.radians(angles_deg))
        pin.forwardKinematics(robot, self._data, serial)
        place = pin.updateFramePlacement(robot, self._data, self._frame)
        return np.array(place.translation)
