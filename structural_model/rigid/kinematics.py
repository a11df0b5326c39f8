"""Rigid motion of the arm for many instants at once, in numpy."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from structural_model.description import RigidRobot

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FrameMotion:
    """Placement and motion of every joint frame, index 0 the base; base axes throughout.

    Parameters
    ----------
    rotation : (n, n_joints + 1, 3, 3) array
        Frame axes as columns.
    position, velocity, acceleration : (n, n_joints + 1, 3) array [m], [m/s], [m/s²]
        Of the origin.
    spin, spin_rate : (n, n_joints + 1, 3) array [rad/s], [rad/s²]
        Angular velocity and acceleration.
    """

    rotation: Array
    position: Array
    velocity: Array
    acceleration: Array
    spin: Array
    spin_rate: Array


class RigidKinematics:
    """Forward kinematics of a tree of joints, vectorised over poses.

    Parameters
    ----------
    robot : RigidRobot
        Joint tree.
    """

    def __init__(self, robot: RigidRobot) -> None:
        model = robot.model
        self.parents = [int(parent) for parent in model.parents]
        self.origins = [
            (np.array(item.rotation), np.array(item.translation)) for item in model.jointPlacements
        ]
        self.axes = [np.zeros(3), *(np.array(joint.axis) for joint in robot.joints)]
        self.prismatic = [False, *(joint.prismatic for joint in robot.joints)]

    def motion(
        self,
        q: ArrayLike,
        qd: ArrayLike | None = None,
        qdd: ArrayLike | None = None,
        *,
        accelerations: bool = True,
    ) -> FrameMotion:
        """Return the motion of every joint frame.

        Parameters
        ----------
        q, qd, qdd : (n, n_joints) array [rad], [rad/s], [rad/s²]
            Serial joint motion; rates default to zero.
        accelerations : bool
            False leaves ``acceleration`` and ``spin_rate`` zero: half of the work.
        """
        angle = np.atleast_2d(np.asarray(q, dtype=float))
        rate = np.zeros_like(angle) if qd is None else np.atleast_2d(np.asarray(qd, dtype=float))
        rise = np.zeros_like(angle) if qdd is None else np.atleast_2d(np.asarray(qdd, dtype=float))
        count, size = len(angle), len(self.parents)
        motion = FrameMotion(
            rotation=np.tile(np.eye(3), (count, size, 1, 1)),
            **{
                name: np.zeros((count, size, 3))
                for name in ('position', 'velocity', 'acceleration', 'spin', 'spin_rate')
            },
        )
        for joint in range(1, size):
            own = [part[:, joint - 1] for part in (angle, rate, rise)]
            self._step(motion, joint, *own, accelerations=accelerations)
        return motion

    def _step(
        self,
        motion: FrameMotion,
        joint: int,
        angle: Array,
        rate: Array,
        rise: Array,
        *,
        accelerations: bool,
    ) -> None:
        parent = self.parents[joint]
        turn, shift = self.origins[joint]
        frame = motion.rotation[:, parent] @ turn
        axis = frame @ self.axes[joint]
        arm = motion.rotation[:, parent] @ shift
        spin, spin_rate = motion.spin[:, parent], motion.spin_rate[:, parent]
        if self.prismatic[joint]:
            arm = arm + axis * angle[:, None]
            rotation, slide, slide_rate = frame, axis * rate[:, None], axis * rise[:, None]
            own_spin = own_rate = np.zeros_like(axis)
        else:
            rotation = frame @ turns(self.axes[joint], angle)
            slide = slide_rate = np.zeros_like(axis)
            own_spin, own_rate = axis * rate[:, None], axis * rise[:, None]
        motion.rotation[:, joint] = rotation
        motion.position[:, joint] = motion.position[:, parent] + arm
        motion.spin[:, joint] = spin + own_spin
        motion.velocity[:, joint] = motion.velocity[:, parent] + np.cross(spin, arm) + slide
        if not accelerations:
            return
        motion.spin_rate[:, joint] = spin_rate + own_rate + np.cross(spin, own_spin)
        motion.acceleration[:, joint] = (
            motion.acceleration[:, parent]
            + np.cross(spin_rate, arm)
            + np.cross(spin, np.cross(spin, arm))
            + 2.0 * np.cross(spin, slide)
            + slide_rate
        )


def turns(axis: Array, angle: Array) -> Array:
    """Return rotations about one axis by many angles (Rodrigues), (n, 3, 3)."""
    x, y, z = axis
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    sine, cosine = np.sin(angle)[:, None, None], np.cos(angle)[:, None, None]
    return np.asarray(np.eye(3) + sine * skew + (1.0 - cosine) * (skew @ skew))


def point_position(motion: FrameMotion, joint: int, place: Array) -> Array:
    """Return where a point fixed to a joint frame is, (n, 3) [m]."""
    return np.asarray(motion.position[:, joint] + motion.rotation[:, joint] @ place)


def point_velocity(motion: FrameMotion, joint: int, place: Array) -> Array:
    """Return how fast a point fixed to a joint frame moves, (n, 3) [m/s]."""
    arm = motion.rotation[:, joint] @ place
    return np.asarray(motion.velocity[:, joint] + np.cross(motion.spin[:, joint], arm))


def point_acceleration(motion: FrameMotion, joint: int, place: Array) -> Array:
    """Return the acceleration of a point fixed to a joint frame, (n, 3) [m/s²]."""
    arm = motion.rotation[:, joint] @ place
    spin = motion.spin[:, joint]
    return np.asarray(
        motion.acceleration[:, joint]
        + np.cross(motion.spin_rate[:, joint], arm)
        + np.cross(spin, np.cross(spin, arm))
    )
