"""Modes of a robot's model as files of other programs, at the places of its sensors."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from autonomous_modal_analysis.export.export import export_modes
from autonomous_modal_analysis.export.exported import Exported
from modal_core.channel import SensorLayout
from modal_core.errors import SettingsError
from modal_core.mode import ModeSet

if TYPE_CHECKING:
    from structural_model.flexible_joint_model import FlexibleJointModel


def export_arm_modes(
    path: Path,
    model: 'FlexibleJointModel',
    layout: SensorLayout,
    q: NDArray[np.float64],
    modes: ModeSet,
    about: Mapping[str, str],
) -> None:
    """Write modes with the arm as it stands in a pose.

    Parameters
    ----------
    path : path
        Its ending says which kind.
    model : FlexibleJointModel
        The robot.
    layout : SensorLayout
        Its sensors, the channels of the modes.
    q : (n_joints,) array [rad]
        Serial joints.
    modes : ModeSet
        Of the model.
    about : mapping of str to str
        Name, version of the software and the like.

    Raises
    ------
    SettingsError
        No such kind, or the robot has no sensors.
    ModalAnalysisError
        A library that it needs is not installed.
    OSError
        It cannot be written.
    """
    from modal_dashboard.arm_drawing import draw_arm

    if not modes.channel_names:
        raise SettingsError(
            'no sensors to see shapes by', where=path, advice='name a sensor layout'
        )
    placed = draw_arm(model, q, layout, modes).placed
    none = ModeSet((), modes.channel_names)
    export_modes(path, Exported(modes, none, about, *placed))
