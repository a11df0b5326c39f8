"""A MoveAbsJ: all axes leave and arrive together, on a straight line in axis angles."""

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from abb_emulator.drives.jerk_profile import jerk_profile, JerkProfile
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]
POSES_ON_THE_WAY = 9
MM = 1000.0
STILL_DEG = 1e-9


@dataclass(frozen=True, slots=True)
class MoveLimits:
    r"""What a program says about a move.

    Parameters
    ----------
    tool_speed_mm_s, turning_deg_s : float [mm/s], [deg/s]
        Of the flange; infinity is none.
    speed_ratio : float
        The operator's, on every speed.
    acceleration, ramp : float
        AccSet as fractions: of the acceleration, and of its build-up (jerk).
    duration_s : float [s]
        ``\T``: in place of the tool speed, so fast that the way takes this long at full speed;
        speeding up and slowing down come on top.  0: the tool speed holds.
    """

    tool_speed_mm_s: float = math.inf
    turning_deg_s: float = math.inf
    speed_ratio: float = 1.0
    acceleration: float = 1.0
    ramp: float = 1.0
    duration_s: float = 0.0


class JointMove:
    """Motion from rest to rest, one ``step`` per controller cycle.

    Parameters
    ----------
    model : FlexibleJointModel
        Limits of the axes, and the way of the flange.
    start_deg, target_deg : (6,) array [deg]
        Controller angles.
    limits : MoveLimits
        As programmed.
    cycle_s : float [s]
        Controller cycle.
    """

    def __init__(
        self,
        model: FlexibleJointModel,
        start_deg: Array,
        target_deg: Array,
        limits: MoveLimits,
        cycle_s: float,
    ) -> None:
        self._start, self._target = np.array(start_deg, float), np.array(target_deg, float)
        self._cycle_s, self._time_s = cycle_s, 0.0
        self._profile = _profile(model, self._start, self._target, limits)
        self.duration_s = self._profile.duration_s if self._profile is not None else 0.0

    @property
    def finished(self) -> bool:
        """The axes are at the target."""
        return self._time_s >= self.duration_s

    def step(self) -> Array:
        """Return the position at the end of the next cycle, (6,) [deg]."""
        self._time_s += self._cycle_s
        if self._profile is None or self.finished:
            return self._target.copy()
        part = self._profile.at(self._time_s)
        return np.asarray(self._start + part * (self._target - self._start))


def _profile(
    model: FlexibleJointModel, start: Array, target: Array, limits: MoveLimits
) -> JerkProfile | None:
    """Return the common profile of all axes, from 0 to 1; None when there is no way to go."""
    way = np.abs(target - start)
    if np.max(way) < STILL_DEG:
        return None

    def least(limit_rad: Array) -> float:
        with np.errstate(divide='ignore'):
            return float(np.min(np.degrees(limit_rad) / way))

    ratio = max(limits.speed_ratio, 1e-3)
    wished = _tool_limit(model, start, target, limits)
    if limits.duration_s > 0.0:
        wished = min(wished, 1.0 / limits.duration_s)
    speed = min(least(model.limits.velocity), wished) * ratio
    return jerk_profile(
        1.0,
        speed,
        limits.acceleration * least(model.limits.acceleration),
        limits.ramp * least(model.limits.jerk),
    )


def _tool_limit(
    model: FlexibleJointModel, start: Array, target: Array, limits: MoveLimits
) -> float:
    """Return the part of the way per second at which the flange is as fast as it may be."""
    part = np.linspace(0.0, 1.0, POSES_ON_THE_WAY)[:, None]
    serial = model.axes.to_serial(np.radians(start + part * (target - start)))
    rate = np.tile(model.axes.to_serial(np.radians(target - start)), (POSES_ON_THE_WAY, 1))
    motion = model.kinematics.motion(serial, rate)
    along = float(np.max(np.linalg.norm(motion.velocity[:, -1], axis=1))) * MM
    turning = math.degrees(float(np.max(np.linalg.norm(motion.spin[:, -1], axis=1))))
    return min(
        limits.tool_speed_mm_s / max(along, 1e-12), limits.turning_deg_s / max(turning, 1e-12)
    )
