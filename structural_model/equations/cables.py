"""How a cable to the ground sees the arm move."""

import numpy as np
from numpy.typing import NDArray
import pinocchio as pin

from structural_model.assembly import Assembly
from structural_model.description import CableSpec
from structural_model.rigid import joint_jacobian

Array = NDArray[np.float64]
STEP = 1e-6
"""Of a coordinate, for slopes by central differences: 3e-10 off at ten arms and cables."""


def cable_stiffness(assembly: Assembly, cable: CableSpec, full: Array) -> Array:
    """Return the load of a cable against unit motions of pinocchio's coordinates, (n_v, n_v).

    k rᵀr - T ∂r/∂q, r how it shortens and T its pull: what pulls resists turning.
    """
    row = cable_row(assembly, cable, full)
    stiffness = cable.stiffness_n_m * np.outer(row, row)
    if cable.pull_n:
        for number, step in enumerate(STEP * np.eye(len(full))):
            beyond, before = (cable_row(assembly, cable, full + way * step) for way in (1, -1))
            stiffness[:, number] -= cable.pull_n * (beyond - before) / (2.0 * STEP)
    return stiffness


def cable_row(assembly: Assembly, cable: CableSpec, full: Array) -> Array:
    """Return by how much a cable shortens per unit of pinocchio's coordinates, (n_v,).

    Parameters
    ----------
    assembly : Assembly
        The expanded arm.
    cable : CableSpec
        From a point of a link to one of the ground.
    full : (n_v,) array
        Where the arm is.
    """
    joint, placement = assembly.attach(cable.link, np.array(cable.position_m))
    data = assembly.data
    pin.computeJointJacobians(assembly.model, data, full)
    arm = data.oMi[joint].rotation @ placement.translation
    way = np.array(cable.anchor_m) - data.oMi[joint].translation - arm
    frame = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    jacobian = joint_jacobian(assembly.model, data, joint, frame)
    point = jacobian[:3] + np.cross(jacobian[3:].T, arm).T
    return np.asarray(way / np.linalg.norm(way) @ point)
