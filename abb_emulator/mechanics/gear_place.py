"""Where the drives act among the flexible coordinates."""

import numpy as np
from numpy.typing import NDArray

from structural_model.flexible_joint_model import FlexibleJointModel


def drive_places(model: FlexibleJointModel) -> NDArray[np.float64]:
    """Return the load on the flexible coordinates per torque of each drive, (n_dof, n_joints).

    Its transpose gives the twist of each controller axis.  A motor behind a soft servo takes the
    reaction.
    """
    place = np.zeros((model.n_dof, model.n_joints))
    axes, names = model.axes.matrix, model.dof_names
    for column, joint in enumerate(model.joint_names):
        # A drive acts on its axis: the twists of all joints that turn it.
        for row, other in enumerate(model.joint_names):
            if f'{joint}/drive' in names and f'{other}/drive' in names:
                place[names.index(f'{other}/drive'), column] = axes[column, row]
        if f'{joint}/motor' in names:
            place[names.index(f'{joint}/motor'), column] = -1.0
    return place
