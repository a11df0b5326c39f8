"""The joint states of the recent past, and the pose of a window."""

from collections import deque

import numpy as np

from modal_core.measurements import JointSamples, NANOSECONDS_PER_SECOND
from modal_core.window import Pose

MOST_SAMPLES = 2_000_000


class JointTrack:
    """Keeps joint states for as long as windows need them.

    Parameters
    ----------
    span_s : float [s]
        How long.
    """

    def __init__(self, span_s: float) -> None:
        self._span_ns = round(span_s * NANOSECONDS_PER_SECOND)
        self._parts: deque[JointSamples] = deque()
        self._n_samples = 0

    def add(self, joints: JointSamples) -> None:
        """Take in joint states; other joints than before begin a new track."""
        if len(joints.stamp_ns) == 0:
            return
        if self._parts and joints.joint_names != self._parts[-1].joint_names:
            self.clear()
        self._parts.append(joints)
        self._n_samples += len(joints.stamp_ns)
        oldest = int(joints.stamp_ns[-1]) - self._span_ns
        while len(self._parts) > 1 and (
            int(self._parts[0].stamp_ns[-1]) < oldest or self._n_samples > MOST_SAMPLES
        ):
            self._n_samples -= len(self._parts.popleft().stamp_ns)

    def clear(self) -> None:
        """Forget everything."""
        self._parts.clear()
        self._n_samples = 0

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
    )


def _effort(part: JointSamples) -> np.ndarray:
    if part.effort.shape == part.position.shape:
        return part.effort
    return np.full(part.position.shape, np.nan)
