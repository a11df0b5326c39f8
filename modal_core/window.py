"""A window is what one identification sees: samples, the pose they were taken in, their health."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from modal_core.measurements import JointSamples
from modal_core.quality import DataQuality
from modal_core.samples import Samples


@dataclass(frozen=True, slots=True)
class Pose:
    """Where the robot was in a window.

    Parameters
    ----------
    joint_names : tuple of str
        One per joint.
    position : (n_joints,) array [rad]
        Mean over the window, serial joints.
    position_range : (n_joints,) array [rad]
        Largest minus smallest in the window.
    """

    joint_names: tuple[str, ...]
    position: NDArray[np.float64]
    position_range: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Window:
    """One window of responses.

    Parameters
    ----------
    index : int
        Counts windows from 0.
    samples : Samples
        Healthy channels only.
    quality : DataQuality
        Health of every expected channel.
    pose : Pose or None
        None when no joint states were received.
    joints : JointSamples or None
        The joint states of the window, for rigid-motion removal and drive harmonics.
    """

    index: int
    samples: Samples
    quality: DataQuality = field(default_factory=DataQuality)
    pose: Pose | None = None
    joints: JointSamples | None = None
