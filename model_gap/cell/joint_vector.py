"""The twist of one drive as a combination of the flexible degrees of freedom."""

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import ModelError
from structural_model import FlexibleJointModel, ModelSpec
from structural_model.description import Spring

BETWEEN_LINKS = 'between links'
_MARK = '@links'


def marked(joint: str, variant: str) -> str:
    """Return the name of a joint's drive axis, or of the joint itself between its two links."""
    return joint + _MARK if BETWEEN_LINKS in variant else joint


def plain_joint(joint: str) -> str:
    """Return the joint's own name."""
    return joint.removesuffix(_MARK)


def in_words(place: str) -> str:
    """Return a marked joint as people read it."""
    joint = plain_joint(place)
    return joint if joint == place else f'{joint} ({BETWEEN_LINKS})'


def axis_row(model: FlexibleJointModel, joint: str) -> NDArray[np.float64]:
    """Return the combination of serial joints a drive turns, or one joint alone."""
    place = model.joint_names.index(plain_joint(joint))
    row = model.axes.matrix[place]
    return np.eye(len(row))[place] if joint.endswith(_MARK) else np.asarray(row)


def is_coupled(model: FlexibleJointModel, joint: str) -> bool:
    """Return whether a drive turns more than its own joint (parallel rod)."""
    return int(np.count_nonzero(axis_row(model, joint))) > 1


def joint_vector(
    model: FlexibleJointModel, joint: str, dof_names: tuple[str, ...]
) -> NDArray[np.float64]:
    """Return w with twist = wᵀx: a row of the axis map over the drives' degrees of freedom.

    Raises
    ------
    ModelError
        The drive is rigid in the model.
    """
    row = axis_row(model, joint)
    vector = np.zeros(len(dof_names))
    for name, weight in zip(model.joint_names, row, strict=True):
        if weight and f'{name}/drive' in dof_names:
            vector[dof_names.index(f'{name}/drive')] = weight
    if f'{joint}/motor' in dof_names:
        vector[dof_names.index(f'{joint}/motor')] = -1.0
    if not vector.any():
        raise ModelError('joint is rigid in the model', found=joint)
    return vector


def force_vector(
    model: FlexibleJointModel, place: str, dof_names: tuple[str, ...]
) -> NDArray[np.float64]:
    """Return the unit force on one degree of freedom, or the unit torque in a joint."""
    if place in dof_names:
        return np.asarray(np.eye(len(dof_names))[dof_names.index(place)])
    return joint_vector(model, place, dof_names)


def joint_spring(spec: ModelSpec, joint: str) -> Spring:
    """Return the drive spring of a joint."""
    return next(item.drive.spring for item in spec.joints if item.name == plain_joint(joint))
