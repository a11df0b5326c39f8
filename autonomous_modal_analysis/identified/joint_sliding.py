"""What part of the time the joints of a recording slid, from their recorded angles."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from excitation_planner.motion import MOVING_S, SlidingJoints
from excitation_planner.request import PlanRequest
from modal_core.measurements import JointSamples, Measurement, NANOSECONDS_PER_SECOND
from oma_identifier.motion import in_model_order, RobotMotion

Array = NDArray[np.float64]
# Rows looked at together: no more are kept, however long the recording.
ROWS = 4096
# Nothing is known of a joint that tells nothing for so long: five times what sliding is seen in
# (MOVING_S), and shorter than any stroke of a sweep, so that no turn is overlooked.
LONGEST_GAP_NS = 500_000_000


@dataclass(frozen=True, slots=True)
class JointSliding:
    """What part of the time each axis slid.

    Parameters
    ----------
    axis_names : tuple of str
        Controller axes, each of which has its gear.
    share : tuple of float
        0..1 of the time their angles were told.
    presliding_rad : float [rad]
        Travel after a turn before a joint slides, assumed.
    """

    axis_names: tuple[str, ...]
    share: tuple[float, ...]
    presliding_rad: float

    def words(self) -> str:
        """Say it, the standing state first of all."""
        if not any(self.share):
            return 'no axis slid: this is the standing state, with friction and lost motion stuck'
        rows = zip(self.axis_names, self.share, strict=True)
        each = ', '.join(f'{name} {100.0 * share:.0f} %' for name, share in rows)
        return f'axes slid this part of the time: {each}'


class SlidingWatch:
    """Joint states in, the share of the time out; memory does not grow with the recording.

    Parameters
    ----------
    robot : RobotMotion or None
        Knows which joint angles belong to which axis; None watches nothing.
    """

    def __init__(self, robot: RobotMotion | None) -> None:
        self._robot = robot
        self._presliding_rad = PlanRequest().presliding_rad
        self._stamps: list[NDArray[np.int64]] = []
        self._rows: list[Array] = []
        self._n_rows = 0
        self._joints: SlidingJoints | None = None
        self._slid_s, self._told_s = np.zeros(0), 0.0

    def add(self, joints: JointSamples) -> None:
        """Take joint states as they come."""
        if self._robot is None or not len(joints.stamp_ns):
            return
        position = in_model_order(joints, self._robot)
        if position is None or not np.isfinite(position).all():
            return
        last_ns = int(self._stamps[-1][-1]) if self._stamps else int(joints.stamp_ns[0])
        if not 0 <= int(joints.stamp_ns[0]) - last_ns <= LONGEST_GAP_NS:
            self._look()
            self._joints = None
        self._stamps.append(joints.stamp_ns)
        self._rows.append(self._robot.to_controller(position))
        self._n_rows += len(position)
        if self._n_rows >= ROWS:
            self._look()

    def found(self) -> JointSliding | None:
        """Return what part of the time they slid; None where none was told."""
        self._look()
        if self._robot is None or self._told_s <= 0.0:
            return None
        share = tuple(float(part) for part in self._slid_s / self._told_s)
        return JointSliding(tuple(self._robot.axis_names), share, self._presliding_rad)

    def _look(self) -> None:
        """Count what has gathered."""
        if self._n_rows < 2:
            self._forget()
            return
        stamps, rows = np.concatenate(self._stamps), np.concatenate(self._rows)
        period_s = float(np.median(np.diff(stamps))) / NANOSECONDS_PER_SECOND
        if 0.0 < period_s <= 0.5 * MOVING_S:
            if self._joints is None:
                self._joints = SlidingJoints(rows[0], self._presliding_rad)
            slid = self._joints.slide(rows, period_s)
            duration_s = len(rows) * period_s
            self._told_s += duration_s
            self._slid_s = np.resize(self._slid_s, rows.shape[1]) + slid.mean(axis=0) * duration_s
        self._forget()

    def _forget(self) -> None:
        self._stamps, self._rows, self._n_rows = [], [], 0


def slid_in(
    measurements: Iterable[Measurement], robot: RobotMotion | None, from_ns: int = 0
) -> JointSliding | None:
    """Return what part of the time the joints of a whole recording slid.

    Parameters
    ----------
    measurements : iterable of Measurement
        Of the recording; all but joint states are passed over.
    robot : RobotMotion or None
        See :class:`SlidingWatch`.
    from_ns : int [ns]
        What was told before does not count.

    Returns
    -------
    JointSliding or None
        None where nothing is told, or no robot known.
    """
    watch = SlidingWatch(robot)
    for measurement in measurements if robot is not None else ():
        if isinstance(measurement, JointSamples) and measurement.stamp_ns[-1:] >= from_ns:
            watch.add(measurement)
    return watch.found()
