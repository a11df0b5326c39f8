"""Forces at the end-effector and torques of the joints, by virtual work.

Eqs. (12)-(16) of Jiao et al. (2025), doi:10.1038/s41598-025-95339-6: what the torques do along a
virtual displacement of the joints, τᵀ δq, is what the force does along that of the end-effector,
Fᵀ D with D = J δq; so τ = Jᵀ F.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from modal_core.errors import ModelError
from structural_model.description import check_length
from structural_model.flexible_joint_model import FlexibleJointModel
from structural_model.rigid import point_velocity

Array = NDArray[np.float64]


def end_effector_jacobian(
    model: FlexibleJointModel,
    q: ArrayLike,
    frame_id: str,
    position_m: Sequence[float] = (0.0, 0.0, 0.0),
) -> Array:
    """Return J of x' = J(q) q', Eq. (16), of a point on a link of the rigid arm.

    Parameters
    ----------
    model : FlexibleJointModel
        The robot.
    q : (n_joints,) array [rad]
        Serial joint angles.
    frame_id : str
        Link, such as ``flange``.
    position_m : (3,) sequence [m]
        The point, in the link's frame.

    Returns
    -------
    (6, n_joints) array [m/rad], [rad/rad]
        Base axes: velocity of the point, then angular velocity, per rate of each serial joint.

    Raises
    ------
    ModelError
        The link is unknown, or q has another length.
    """
    joint, placement = model.assembly.link(frame_id)
    # One row per joint, which moves alone at a rate of 1.
    rates = np.eye(model.n_joints)
    angles = np.broadcast_to(check_length(q, model.joint_names, model.robot_name), rates.shape)
    motion = model.kinematics.motion(angles, rates, accelerations=False)
    place = placement.act(np.asarray(position_m, dtype=float))
    return np.vstack([point_velocity(motion, joint, place).T, motion.spin[:, joint].T])


def joint_torque(jacobian: ArrayLike, force: ArrayLike) -> Array:
    """Return the joint torques that stand for forces at the end-effector, τ = Jᵀ F, Eq. (15).

    Parameters
    ----------
    jacobian : (6, n_joints) array
        See :func:`end_effector_jacobian`.
    force : (6,) or (n, 6) array [N], [N m]
        Forces along, then torques about the axes of the base, at the Jacobian's point.

    Returns
    -------
    (n_joints,) or (n, n_joints) array [N m]
        Of the serial joints; ``model.axes.torque_to_controller`` gives those of the drives.

    Raises
    ------
    ModelError
        The shapes do not fit.
    """
    rows, load = np.asarray(jacobian, dtype=float), np.asarray(force, dtype=float)
    if rows.ndim != 2 or load.ndim not in (1, 2) or load.shape[-1] != len(rows):
        raise ModelError(
            'forces do not fit the Jacobian',
            found=f'{load.shape} and {rows.shape}',
            expected='(6,) or (n, 6), and (6, n_joints)',
        )
    return np.asarray(load @ rows)
