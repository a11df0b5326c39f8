"""Springs of the drives: gear twist on controller axes, servo stiffness, coupling rods."""

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import ModelError
from structural_model.description import AxisMap, check_spring, ModelSpec, RigidRobot, Spring


def add_drive_springs(
    stiffness: NDArray[np.float64],
    damping: NDArray[np.float64],
    dof_names: list[str],
    robot: RigidRobot,
    spec: ModelSpec,
    axes: AxisMap,
) -> None:
    """Add K += k wwᵀ and C += c wwᵀ of every drive, servo and rod.

    A drive acts on its controller axis: w is a row of T over the joint twists, minus its motor's
    own deviation where the servo is not stiff (Spong's model of a flexible joint).

    Parameters
    ----------
    stiffness, damping : (n_dof, n_dof) array
        Changed in place.
    dof_names : list of str
        Rows of the matrices.
    robot, spec, axes
        The arm, its flexibilities, and T.

    Raises
    ------
    ModelError
        A rigid drive on a coupled axis, a soft servo without rotor or gear compliance, an unknown
        joint in a rod.

    References
    ----------
    Spong (1987), doi:10.1115/1.3143860.
    """
    by_name = {joint.name: joint.drive for joint in spec.joints}
    for number, joint in enumerate(robot.joint_names):
        drive = by_name[joint]
        weights = {
            f'{robot.joint_names[other]}/drive': float(axes.matrix[number, other])
            for other in np.flatnonzero(axes.matrix[number])
        }
        where = f'{robot.name}: {joint}'
        if drive.spring.rigid:
            _check_rigid(weights, joint, dof_names, where)
            if not drive.servo.rigid:
                raise ModelError('a soft servo needs a drive stiffness', where=where)
            continue
        if not drive.servo.rigid:
            if drive.rotor_inertia_kg_m2 <= 0.0:
                raise ModelError('a soft servo needs a rotor inertia', where=where)
            weights[f'{joint}/motor'] = -1.0
            _add(stiffness, damping, dof_names, {f'{joint}/motor': 1.0}, drive.servo, where)
        _add(stiffness, damping, dof_names, weights, drive.spring, where)
    for rod in spec.rods:
        weights = {f'{name}/drive': weight for name, weight in rod.weights}
        _add(stiffness, damping, dof_names, weights, rod.spring, f'{robot.name}: {rod.name}')


def _check_rigid(weights: dict[str, float], joint: str, dof_names: list[str], where: str) -> None:
    others = [name for name in weights if name != f'{joint}/drive' and name in dof_names]
    if others:
        raise ModelError(
            'a rigid drive on a coupled axis needs the other drive rigid too',
            where=where,
            found=', '.join(others),
        )


def _add(
    stiffness: NDArray[np.float64],
    damping: NDArray[np.float64],
    dof_names: list[str],
    weights: dict[str, float],
    spring: Spring,
    where: str,
) -> None:
    check_spring(spring, where)
    if spring.rigid:
        raise ModelError('spring without a finite stiffness', where=where)
    places = [dof_names.index(name) for name in weights if name in dof_names]
    vector = np.array([weights[dof_names[place]] for place in places])
    at = np.array(places, dtype=np.intp)[:, None], places
    whole = np.outer(vector, vector)
    stiffness[at] += spring.stiffness * whole
    damping[at] += spring.damping * whole
