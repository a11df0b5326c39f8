"""The joint states of the recent past, and the pose of a window."""

from collections import Counter, deque
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from modal_core.measurements import JointSamples, NANOSECONDS_PER_SECOND
from modal_core.window import Pose
from oma_identifier.intake.thresholds import INTAKE
from oma_identifier.time_axis import Candidates, TIME_AXIS

SPEED_STEP_NS = 100_000_000
"""Between the angles whose difference is the speed: the ripple of encoders is none."""


class JointTrack:
    """Keeps joint states for as long as windows need them.

    A stamp far from the last and from the samples' time, or other joints than before, must be
    confirmed by the next messages.

    Parameters
    ----------
    span_s : float [s]
        How long.
    set_aside : Counter or None
        Where joint states that nothing confirms are counted.
    """

    def __init__(self, span_s: float, set_aside: 'Counter[str] | None' = None) -> None:
        self._span_ns = round(span_s * NANOSECONDS_PER_SECOND)
        self._parts: deque[JointSamples] = deque()
        self._n_samples = 0
        self._n_numbers = 0
        self._newest_ns = 0
        self._set_aside: Counter[str] = Counter() if set_aside is None else set_aside
        self._suspects: Candidates[JointSamples] = Candidates(_follows, _size, self._drop)

    def add(self, joints: JointSamples, now_ns: int | None = None) -> None:
        """Take in joint states; other joints than before, once confirmed, begin a new track.

        Parameters
        ----------
        joints : JointSamples
            In order of arrival.
        now_ns : int or None [ns]
            Time of the samples; None before the first.
        """
        if len(joints.stamp_ns) == 0:
            return
        same = bool(self._parts) and joints.joint_names == self._parts[-1].joint_names
        ahead = joints.stamp_ns - self._newest_ns
        steps = np.diff(joints.stamp_ns, prepend=joints.stamp_ns[:1])
        if (
            same
            and ahead[0] >= -TIME_AXIS.reorder_ns
            and ahead[0] <= TIME_AXIS.forward_ns
            and _is_steady(steps)
        ):
            self._suspects.clear()
            self._keep(joints)
            return
        for row in range(len(joints.stamp_ns)):
            self._add_one(_rows(joints, slice(row, row + 1)), now_ns)

    def _add_one(self, joints: JointSamples, now_ns: int | None) -> None:
        if self._goes_on(joints, now_ns):
            self._suspects.clear()
            self._keep(joints)
            return
        run = self._suspects.add(joints)
        if run.n_items < TIME_AXIS.confirm:
            return
        other = bool(self._parts) and joints.joint_names != self._parts[-1].joint_names
        if other or int(run.first.stamp_ns[0]) < self._newest_ns:
            self.clear()
        for part in self._suspects.take(run):
            self._keep(part)
        self._suspects.clear()

    def _goes_on(self, joints: JointSamples, now_ns: int | None) -> bool:
        if not self._parts:
            return False
        last = self._parts[-1]
        in_time = now_ns is not None and abs(int(joints.stamp_ns[0]) - now_ns) <= INTAKE.near_ns
        return joints.joint_names == last.joint_names and (
            in_time
            or -TIME_AXIS.reorder_ns
            <= int(joints.stamp_ns[0]) - self._newest_ns
            <= TIME_AXIS.forward_ns
        )

    def _keep(self, joints: JointSamples) -> None:
        self._parts.append(joints)
        self._newest_ns = int(joints.stamp_ns[-1])
        self._n_samples += len(joints.stamp_ns)
        self._n_numbers += _size(joints) // 8
        oldest = self._newest_ns - self._span_ns
        while len(self._parts) > 1 and (
            int(self._parts[0].stamp_ns[-1]) < oldest
            or self._n_samples > INTAKE.most_joint_samples
            or self._n_numbers > INTAKE.most_joint_numbers
        ):
            gone = self._parts.popleft()
            self._n_samples -= len(gone.stamp_ns)
            self._n_numbers -= _size(gone) // 8

    def _drop(self, parts: Sequence[JointSamples]) -> None:
        self._set_aside['joints_unconfirmed'] += len(parts)

    def flush(self) -> None:
        """Take in what waits, at the end of a record too short to confirm anything."""
        run = self._suspects.longest()
        if not self._parts and run is not None:
            for part in self._suspects.take(run):
                self._keep(part)
        self._suspects.clear()

    def expire(self, now_ns: int) -> None:
        """Keep what the samples' time confirms of the joint states that wait; drop the others."""
        run = self._suspects.longest()
        if not self._parts and run is not None:
            age_ns = now_ns - int(run.held[-1].stamp_ns[0])
            if -INTAKE.near_ns <= age_ns <= self._span_ns:
                self.flush()
        self._suspects.expire()

    def clear(self) -> None:
        """Forget everything."""
        self._parts.clear()
        self._n_samples = self._n_numbers = 0

    def between(self, start_ns: int, end_ns: int) -> JointSamples | None:
        """Return the joint states of a window in order; None when there are none."""
        parts = [
            part
            for part in self._parts
            if part.stamp_ns.max() >= start_ns and part.stamp_ns.min() < end_ns
        ]
        if not parts:
            return None
        stamps = np.concatenate([part.stamp_ns for part in parts])
        order = np.argsort(stamps, kind='stable')
        inside = order[(stamps[order] >= start_ns) & (stamps[order] < end_ns)]
        if len(inside) == 0:
            return None
        return JointSamples(
            stamp_ns=stamps[inside],
            joint_names=parts[0].joint_names,
            position=np.concatenate([part.position for part in parts])[inside],
            velocity=np.concatenate([part.velocity for part in parts])[inside],
            effort=np.concatenate([_effort(part) for part in parts])[inside],
        )


def pose_of(joints: JointSamples | None) -> Pose | None:
    """Return mean and range of the joint positions."""
    if joints is None:
        return None
    return Pose(
        joint_names=joints.joint_names,
        position=joints.position.mean(axis=0),
        position_range=np.ptp(joints.position, axis=0),
        mean_speed=_mean_speed(joints),
    )


def _mean_speed(joints: JointSamples) -> NDArray[np.float64] | None:
    """Return the mean magnitude of the joints' speeds, between angles too far apart for noise."""
    stamps = joints.stamp_ns
    asked = np.arange(stamps[0], stamps[-1] + 1, SPEED_STEP_NS)
    if len(asked) < 2:
        return None
    rows = np.unique(np.searchsorted(stamps, asked))
    way = np.abs(np.diff(joints.position[rows], axis=0)).sum(axis=0)
    span_s = (stamps[rows[-1]] - stamps[rows[0]]) / NANOSECONDS_PER_SECOND
    return np.asarray(way / span_s) if span_s > 0.0 else None


def _rows(joints: JointSamples, rows: slice) -> JointSamples:
    effort = joints.effort
    return JointSamples(
        stamp_ns=joints.stamp_ns[rows],
        joint_names=joints.joint_names,
        position=joints.position[rows],
        velocity=joints.velocity[rows],
        effort=effort[rows] if effort.shape == joints.position.shape else effort,
    )


def _size(joints: JointSamples) -> int:
    return joints.position.nbytes + joints.velocity.nbytes + joints.effort.nbytes


def _follows(last: JointSamples, joints: JointSamples) -> bool:
    """Tell whether one joint state continues another: the same joints, not long after."""
    ahead = int(joints.stamp_ns[0]) - int(last.stamp_ns[-1])
    return (
        joints.joint_names == last.joint_names
        and -TIME_AXIS.reorder_ns <= ahead <= TIME_AXIS.forward_ns
    )


def _is_steady(steps: np.ndarray) -> bool:
    return bool(np.all((steps >= -TIME_AXIS.reorder_ns) & (steps <= TIME_AXIS.forward_ns)))


def _effort(part: JointSamples) -> np.ndarray:
    if part.effort.shape == part.position.shape:
        return part.effort
    return np.full(part.position.shape, np.nan)
