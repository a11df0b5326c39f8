"""Poses that hold the tool point and turn the tool about an axis of its own, as about a spindle.

Along the turn θ the joints obey J(q) dq/dθ = (0, a): the tool point rests, the tool turns about a.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from modal_core.errors import ModelError
from workspace_map.arm.arm_at_pose import Arm

Array = NDArray[np.float64]
STEP_RAD = np.deg2rad(1.0)
"""Of the integration (Runge and Kutta, fourth order): the point strays by less than 1 µm."""
FASTEST = 10.0
"""Largest dq/dθ: beyond it the arm is near a singular pose, and the turn ends there."""
MISSED = 1e-6
"""Of a unit turn, that the joints may miss: an arm of fewer than six cannot turn about a point."""


@dataclass(frozen=True)
class TurnedPose:
    """A pose with the tool turned.

    Parameters
    ----------
    turn_rad : float [rad]
        About the axis.
    q : (n_joints,) array [rad]
        Serial joint angles.
    axes : (3, 3) array
        Takes a vector from the tool's axes to those it had before the turn.
    """

    turn_rad: float
    q: Array
    axes: Array


def turned_poses(
    arm: Arm, q: ArrayLike, axis: ArrayLike, reach_rad: float, spacing_rad: float
) -> tuple[TurnedPose, ...]:
    """Return the poses at even turns either way, as far as joints and singular poses let.

    Parameters
    ----------
    arm : Arm
        With its tool point.
    q : (n_joints,) array [rad]
        Where the turn is 0; serial joint angles.
    axis : (3,) array
        In the tool's axes; of any length.
    reach_rad, spacing_rad : float [rad]
        Largest turn either way, and between two poses.

    Returns
    -------
    tuple of TurnedPose
        By turn.

    Raises
    ------
    ModelError
        The pose is outside the robot's range.
    """
    start = arm.model.check_pose(q)
    along = np.asarray(axis, dtype=float)
    along = along / np.linalg.norm(along)
    count = int(np.floor(reach_rad / spacing_rad + 1e-9))
    found = [_placed(0.0, start, along)]
    for way in (1.0, -1.0):
        here: Array | None = start
        for number in range(1, count + 1):
            here = None if here is None else _turned(arm, here, along, way * spacing_rad)
            if here is None:
                break
            found.append(_placed(way * number * spacing_rad, here, along))
    return tuple(sorted(found, key=lambda each: each.turn_rad))


def _placed(turn_rad: float, q: Array, axis: Array) -> TurnedPose:
    return TurnedPose(turn_rad, q, Rotation.from_rotvec(turn_rad * axis).as_matrix())


def _turned(arm: Arm, q: Array, axis: Array, turn_rad: float) -> Array | None:
    """Return the joints after a turn; None where they cannot follow."""
    steps = max(1, int(np.ceil(abs(turn_rad) / STEP_RAD)))
    size = turn_rad / steps
    for _ in range(steps):
        slopes: list[Array] = []
        for part in (0.0, 0.5, 0.5, 1.0):
            slope = _slope(arm, q + part * size * slopes[-1] if slopes else q, axis)
            if slope is None:
                return None
            slopes.append(slope)
        first, second, third, fourth = slopes
        q = q + size / 6.0 * (first + 2.0 * second + 2.0 * third + fourth)
    try:
        return np.asarray(arm.model.check_pose(q), dtype=float)
    except ModelError:
        return None


def _slope(arm: Arm, q: Array, axis: Array) -> Array | None:
    wanted = np.concatenate([np.zeros(3), axis])
    rows = arm.model.rigid_jacobian(q, arm.tool.channels())
    slope = np.linalg.lstsq(rows, wanted, rcond=1e-9)[0]
    missed = float(np.max(np.abs(rows @ slope - wanted)))
    if missed > MISSED or float(np.max(np.abs(slope))) > FASTEST:
        return None
    return np.asarray(slope)
