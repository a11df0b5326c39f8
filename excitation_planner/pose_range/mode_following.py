"""Natural frequencies along a path of poses, each mode followed by its shape."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]
# Poses in between, so that a shape changes little from one to the next.
LARGEST_STEP_RAD = np.deg2rad(2.0)
# Modes above the band are carried along, so that one can leave it and come back.
BEYOND_BAND = 1.5


@dataclass(frozen=True, slots=True)
class FollowedModes:
    """Where the modes of the first pose have got to.

    Parameters
    ----------
    frequency_hz : (n_modes,) array [Hz]
        In the order of the first pose.
    shapes : (n_dof, n_modes) array
        Mass-normalised, same order.
    """

    frequency_hz: Array
    shapes: Array


def modes_at(model: FlexibleJointModel, q: Array, highest_hz: float) -> FollowedModes:
    """Return the modes of a pose up to ``highest_hz`` and some way beyond."""
    modes = model.modes(q)
    keep = modes.frequency_hz <= BEYOND_BAND * highest_hz
    return FollowedModes(modes.frequency_hz[keep], modes.shapes[:, keep])


def follow(
    model: FlexibleJointModel, start: FollowedModes, q_from: Array, q_to: Array
) -> FollowedModes:
    """Follow modes from one pose to another along a straight line in joint space.

    Parameters
    ----------
    model : FlexibleJointModel
        The robot.
    start : FollowedModes
        At ``q_from``.
    q_from, q_to : (n_joints,) array [rad]
        Ends of the line.
    """
    n_steps = max(1, int(np.ceil(np.max(np.abs(q_to - q_from)) / LARGEST_STEP_RAD)))
    current = start
    for step in range(1, n_steps + 1):
        current = _next(model, current, q_from + (q_to - q_from) * step / n_steps)
    return current


def _next(model: FlexibleJointModel, current: FollowedModes, q: Array) -> FollowedModes:
    """Pair modes of neighbouring poses by the mass-weighted product of their shapes."""
    modes = model.modes(q)
    # Mass-normalised shapes: inv(shapes) = shapesᵀ M, so no mass matrix is needed.
    likeness = np.abs(np.linalg.solve(modes.shapes, current.shapes)) ** 2
    rows, columns = linear_sum_assignment(-likeness)
    order = np.empty(current.shapes.shape[1], dtype=int)
    order[columns] = rows
    return FollowedModes(modes.frequency_hz[order], modes.shapes[:, order])
