"""A pose as people name it: a name, angles of axes or of joints in degrees, or a recording.

Of joints that slide the numbers are metres.

A robot with a parallel rod has two sets of angles: those of the controller axes (``axis_1``, ...),
which the controller shows, and those of the serial joints (``joint_1``, ...), which joint states
and plans carry.  They differ there, and so do the modes.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import ModelError
from modal_core.measurements import JointSamples
from modal_recordings import open_recording
from structural_model.description import read_values, unit_of
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]
PoseGiven = str | Path | Sequence[float] | None


def parse_pose(model: FlexibleJointModel, pose: PoseGiven, serial: bool = False) -> Array:
    """Return serial joint angles of a pose.

    Parameters
    ----------
    model : FlexibleJointModel
        The robot.
    pose : str, path, sequence of float [deg] or None
        A named pose; angles, in a text separated by commas; a recording, whose mean pose is
        taken; None: the robot's first named pose, without one zero.  Of joints that slide [m].
    serial : bool
        The angles are those of the serial joints, as in joint states; else those of the
        controller axes (for the IRB 6660 the coupled J3).

    Returns
    -------
    (n_joints,) array [rad]

    Raises
    ------
    ModelError
        An unknown name, a wrong number of angles, a recording without the robot's joints, or a
        pose outside the joint ranges.
    """
    if pose is None:
        return model.check_pose(model.usual_pose())
    if isinstance(pose, str) and pose in model.poses_controller_rad:
        return model.pose(pose)
    if isinstance(pose, (str, Path)) and Path(pose).exists():
        return model.check_pose(recorded_pose(model, Path(pose)))
    angles = read_values(_values(model, pose), model.sliding)
    return model.check_pose(angles if serial else model.to_serial(angles))


def recorded_pose(model: FlexibleJointModel, path: Path) -> Array:
    """Return the mean pose of a recording, from its joint states, (n_joints,) [rad].

    Raises
    ------
    ModelError
        It has no states of all the robot's joints.
    """
    total, count = np.zeros(model.n_joints), 0
    for part in open_recording(path, to_look=True).measurements():
        if isinstance(part, JointSamples) and set(model.joint_names) <= set(part.joint_names):
            columns = [part.joint_names.index(name) for name in model.joint_names]
            rows = part.position[np.isfinite(part.position[:, columns]).all(axis=1)]
            total, count = total + rows[:, columns].sum(axis=0), count + len(rows)
    if not count:
        raise ModelError(
            'no joint states of this robot',
            where=path,
            expected=', '.join(model.joint_names),
        )
    return np.asarray(total / count)


def _values(model: FlexibleJointModel, pose: str | Path | Sequence[float]) -> list[float]:
    """Return the numbers of a pose, in degrees or metres."""
    parts = str(pose).split(',') if isinstance(pose, (str, Path)) else pose
    try:
        values = [float(part) for part in parts]
    except (ValueError, TypeError) as error:
        raise ModelError(
            'neither a named pose, nor angles, nor a recording',
            where='pose',
            found=pose,
            expected=', '.join([*model.poses_controller_rad, _numbers(model)]),
        ) from error
    if len(values) != model.n_joints:
        raise ModelError(
            'wrong number of angles', where='pose', found=len(values), expected=model.n_joints
        )
    return values


def _numbers(model: FlexibleJointModel) -> str:
    """Return which numbers a pose has, for messages."""
    if not any(model.sliding):
        return f'or {model.n_joints} angles in degrees, separated by commas'
    units = ', '.join(map(unit_of, model.sliding))
    return f'or {model.n_joints} numbers [{units}], separated by commas'
