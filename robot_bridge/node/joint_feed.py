"""Joint angles of the controller on the host's clock, in the model's joints."""

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modal_core.measurements import NANOSECONDS_PER_SECOND
from robot_bridge.egm import RobotFeedback
from robot_bridge.node.clock_map import ClockMap
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]
LONGEST_QUEUE = 4096


@dataclass(frozen=True, slots=True)
class JointSample:
    """Joint angles at one time.

    Parameters
    ----------
    stamp_ns : int [ns]
        Host time of the measurement.
    position : (n_joints,) array [rad]
        Serial joints, motor side.
    velocity : (n_joints,) array [rad/s] or None
        None for the first of a series.
    reference : (n_joints,) array [rad] or None
        What was asked for, None when nothing was.
    """

    stamp_ns: int
    position: Array
    velocity: Array | None
    reference: Array | None


class JointFeed:
    """Takes feedback in the link's thread, gives samples in another.

    Parameters
    ----------
    model : FlexibleJointModel
        The robot.
    """

    def __init__(self, model: FlexibleJointModel) -> None:
        self._model, self._clock = model, ClockMap()
        self._queue: deque[tuple[int, RobotFeedback, Array | None]] = deque(maxlen=LONGEST_QUEUE)
        self._last: tuple[int, Array] | None = None

    def add(
        self, feedback: RobotFeedback, receipt_ns: int, reference_deg: Array | None = None
    ) -> None:
        """Take one feedback, its receipt [ns] and the reference (6,) [deg]."""
        stamp_ns = self._clock.stamp_ns(feedback.time_us, receipt_ns)
        self._queue.append((stamp_ns, feedback, reference_deg))

    def samples(self) -> Iterator[JointSample]:
        """Yield what has come since."""
        while self._queue:
            stamp_ns, feedback, reference_deg = self._queue.popleft()
            position = self._serial(np.asarray(feedback.joints_deg))
            last, self._last = self._last, (stamp_ns, position)
            velocity = None
            if last is not None and 0 < stamp_ns - last[0] < NANOSECONDS_PER_SECOND:
                # EGM reports no speed: the difference of the angles, half a cycle late.
                velocity = (position - last[1]) / ((stamp_ns - last[0]) / NANOSECONDS_PER_SECOND)
            reference = None if reference_deg is None else self._serial(reference_deg)
            yield JointSample(stamp_ns, position, velocity, reference)

    def _serial(self, angles_deg: Array) -> Array:
        return np.asarray(self._model.to_serial(np.radians(angles_deg)))
