"""Whether the arm stays clear of itself over a whole motion, between the poses too.

A distance at one pose proves a stretch of the motion: no point moves by more than the sum over
joints of reach times angle, so while that stays below the distance nothing can touch.
"""

import numpy as np
from numpy.typing import NDArray

from structural_model.description import RigidRobot, Shape
from structural_model.flexible_joint_model import FlexibleJointModel
from structural_model.rigid import Clearance

Array = NDArray[np.float64]
# Part of the clearance a stretch may use up before the distance is measured again.
USED_UP = 0.5
# Below this the motion is taken sample by sample.
SMALLEST_STEP_M = 1e-4


def reach_m(robot: RigidRobot) -> Array:
    """Return how far a point that a joint moves can be from it in any pose, (n_joints,) [m].

    The chain beyond the joint, stretched straight.
    """
    model = robot.model
    reach = np.zeros(len(robot.joints))
    for shape in robot.shapes:
        joint, place = robot.links[shape.link]
        length = float(np.linalg.norm(place.act(shape.position))) + _radius(shape)
        while joint > 0:
            reach[joint - 1] = max(reach[joint - 1], length)
            length += float(np.linalg.norm(model.jointPlacements[joint].translation))
            joint = int(model.parents[joint])
    return reach


def proven_clearance(
    model: FlexibleJointModel, position: Array, least_m: float
) -> Clearance | None:
    """Return a distance that two links which are not neighbours never fall below.

    Parameters
    ----------
    model : FlexibleJointModel
        With its geometry.
    position : (n_samples, n_joints) array [rad]
        Rows close enough together that the arm moves little between them.
    least_m : float [m]
        The search ends at the first pose that comes closer.

    Returns
    -------
    Clearance or None
        None when the robot has no pair to check.
    """
    reach = reach_m(model.robot)
    best: Clearance | None = None
    row = 0
    while row < len(position):
        here = model.geometry.clearance(position[row])
        if here is None:
            return None
        moved = np.abs(position[row:] - position[row]) @ reach
        allowed = max(USED_UP * (here.distance_m - least_m), SMALLEST_STEP_M)
        beyond = np.flatnonzero(moved > allowed)
        step = max(int(beyond[0]) if len(beyond) else len(moved), 1)
        proven = here.distance_m - float(np.max(moved[:step]))
        if here.distance_m < least_m:
            return Clearance(here.distance_m, here.first, here.second, row)
        if best is None or proven < best.distance_m:
            best = Clearance(proven, here.first, here.second, row)
        row += step
    return best


def _radius(shape: Shape) -> float:
    if shape.box is not None:
        return float(np.linalg.norm(shape.box)) / 2.0
    return shape.length / 2.0 + shape.radius
