"""Where the joints stood during a recording: about one pose, or along a way."""

from collections.abc import Callable
import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_gap.campaign.campaign import GapRecord

Array = NDArray[np.float64]
# [rad] root mean square about the mean of a stretch of the way.  Gravity turned by σ reads
# g σ²/2 less on the mean: 0.008 m/s², below what a mean is known to (``UsualErrors``).
NARROW_RAD = 0.04


@dataclass(frozen=True)
class Travel:
    """Mean motion of the joints in consecutive stretches of one recording.

    Parameters
    ----------
    position, velocity, acceleration : (n_stretches, n_joints) array [rad], [rad/s], [rad/s²]
        Means: of an arm that shakes about one pose a single stretch.
    share : (n_stretches,) array
        Of the recording's time.
    """

    position: Array
    velocity: Array
    acceleration: Array
    share: Array

    def changed(self, change: Callable[[Array], Array]) -> 'Travel':
        """Return it with all its motion, (n_stretches, n_joints) each, changed alike."""
        return dataclasses.replace(
            self,
            position=change(self.position),
            velocity=change(self.velocity),
            acceleration=change(self.acceleration),
        )


def standing(pose: Array) -> Travel:
    """Return the travel of joints that stand still at a pose, (n_joints,) [rad]."""
    still = np.zeros((1, len(pose)))
    return Travel(pose[None], still, still, np.ones(1))


def travel_of(record: GapRecord, narrow_rad: float = NARROW_RAD) -> Travel:
    """Return the travel of a recording, in as few stretches as its means need.

    Stretches are halved until the joints turn less than ``narrow_rad`` (rms) within any.
    """
    shift, count = record.motor_shift, 1
    while 2 * count <= len(shift) and _widest(shift, count) > narrow_rad:
        count *= 2
    edges = np.linspace(0, len(shift), count + 1).astype(int)

    def means(values: Array) -> Array:
        sums = np.add.reduceat(values, edges[:-1], axis=0)
        return np.asarray(sums / np.diff(edges)[:, None])

    return Travel(
        position=record.pose + means(shift),
        velocity=means(record.motor_velocity),
        acceleration=means(record.motor_acceleration),
        share=np.diff(edges) / len(shift),
    )


def _widest(shift: Array, count: int) -> float:
    """Return the largest root mean square about the mean of so many stretches."""
    parts = np.array_split(shift, count)
    return max(float(part.std(axis=0).max()) for part in parts)
