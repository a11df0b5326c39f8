"""How fast joints were in a stretch of time, and what turns with them."""

import numpy as np
from numpy.typing import NDArray

from modal_core.measurements import JointSamples, NANOSECONDS_PER_SECOND
from oma_identifier.motion import RobotMotion

Array = NDArray[np.float64]
STEP_NS = 50_000_000
"""Between the angles whose difference is the speed: the ripple of encoders is none."""


def mean_speeds(joints: JointSamples | None, start_ns: int, end_ns: int) -> Array | None:
    """Return the mean magnitude of each joint's speed.

    Parameters
    ----------
    joints : JointSamples or None
        Angles.
    start_ns, end_ns : int [ns]
        Of the stretch.

    Returns
    -------
    (n_joints,) array [rad/s] or None
        None where the angles do not cover the stretch.
    """
    if joints is None or len(joints.stamp_ns) < 2:
        return None
    stamps = joints.stamp_ns
    if stamps[0] > start_ns + STEP_NS or stamps[-1] < end_ns - STEP_NS:
        return None
    asked = np.arange(start_ns, end_ns + 1, STEP_NS)
    told = (stamps - start_ns) / NANOSECONDS_PER_SECOND
    at_s = (asked - start_ns) / NANOSECONDS_PER_SECOND
    angles = np.column_stack([np.interp(at_s, told, column) for column in joints.position.T])
    speeds = np.abs(np.diff(angles, axis=0)).sum(axis=0) / at_s[-1]
    return speeds if np.isfinite(speeds).all() else None


def motor_turns(robot: RobotMotion | None, names: tuple[str, ...]) -> list[tuple[float, ...]]:
    """Return how often motors turn for one turn of each joint, those that it turns.

    Parameters
    ----------
    robot : RobotMotion or None
        Knows its gears; None: nothing is known.
    names : tuple of str
        Of the joints.

    Returns
    -------
    list of tuple of float
        One per joint; empty where not known.
    """
    if robot is None or not set(names) <= set(robot.joint_names):
        return [()] * len(names)
    rest = np.zeros((1, len(robot.joint_names)))
    found = []
    for name in names:
        moved = rest.copy()
        moved[0, robot.joint_names.index(name)] = 1.0
        turns = np.abs(robot.drive_angle(moved) - robot.drive_angle(rest))[0]
        found.append(tuple(float(value) for value in turns if value > 0.0))
    return found
