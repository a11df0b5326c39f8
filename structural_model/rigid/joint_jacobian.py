"""How a joint's frame moves with every coordinate, whatever their number."""

import numpy as np
from numpy.typing import NDArray
import pinocchio as pin

SPATIAL = 6


def joint_jacobian(
    model: pin.Model, data: pin.Data, joint: int, frame: pin.ReferenceFrame
) -> NDArray[np.float64]:
    """Return the Jacobian of a joint, linear rows first, (6, n_v).

    Pinocchio's Python bindings hand out a matrix of one column as a vector: an arm of one joint
    has such a one.

    Parameters
    ----------
    model, data : pinocchio.Model, pinocchio.Data
        After ``computeJointJacobians`` at the pose.
    joint : int
        Pinocchio's number of it.
    frame : pinocchio.ReferenceFrame
        Whose axes and origin.
    """
    return np.asarray(pin.getJointJacobian(model, data, joint, frame)).reshape(SPATIAL, model.nv)
