"""A pose as people name it: a name from the robot's file, or controller angles in degrees."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import ModelError
from structural_model.flexible_joint_model import FlexibleJointModel


def parse_pose(
    model: FlexibleJointModel, pose: str | Sequence[float] | None
) -> NDArray[np.float64]:
    """Return serial joint angles of a pose.

    Parameters
    ----------
    model : FlexibleJointModel
        The robot.
    pose : str, sequence of float [deg] or None
        A named pose, or angles as the controller shows them (for the IRB 6660 the coupled J3), in
        a text separated by commas; None: the robot's first named pose.

    Returns
    -------
    (n_joints,) array [rad]

    Raises
    ------
    ModelError
        An unknown name, a wrong number of angles, or a pose outside the joint ranges.
    """
    if pose is None:
        return model.pose(next(iter(model.poses_controller_rad)))
    if isinstance(pose, str) and pose in model.poses_controller_rad:
        return model.pose(pose)
    parts = pose.split(',') if isinstance(pose, str) else pose
    try:
        angles_deg = [float(part) for part in parts]
    except (ValueError, TypeError) as error:
        raise ModelError(
            'neither a named pose nor angles',
            where='pose',
            found=pose,
            expected=f'{", ".join(model.poses_controller_rad)}, or {model.n_joints} angles'
            ' in degrees, separated by commas',
        ) from error
    if len(angles_deg) != model.n_joints:
        raise ModelError(
            'wrong number of angles', where='pose', found=len(angles_deg), expected=model.n_joints
        )
    q = model.to_serial(np.deg2rad(angles_deg))
    model.check_pose(q)
    return q
