"""A pose as people name it: a name from the robot's file, or controller angles in degrees."""

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import ModelError
from structural_model.flexible_joint_model import FlexibleJointModel


def parse_pose(model: FlexibleJointModel, text: str | None) -> NDArray[np.float64]:
    """Return serial joint angles of a pose.

    Parameters
    ----------
    model : FlexibleJointModel
        The robot.
    text : str or None
        A named pose, or angles in degrees as the controller shows them (for the IRB 6660 the
        coupled J3), separated by commas; None: the robot's first named pose.

    Returns
    -------
    (n_joints,) array [rad]

    Raises
    ------
    ModelError
        An unknown name, a wrong number of angles, or a pose outside the joint ranges.
    """
    if text is None:
        return model.pose(next(iter(model.poses_controller_rad)))
    if text in model.poses_controller_rad:
        return model.pose(text)
    try:
        angles_deg = [float(part) for part in text.split(',')]
    except ValueError as error:
        raise ModelError(
            'neither a named pose nor angles',
            where='pose',
            found=text,
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
