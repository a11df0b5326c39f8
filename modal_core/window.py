"""A window is what one identification sees: samples, the pose they were taken in, their health."""

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from modal_core.measurements import JointSamples
from modal_core.mode import ModeSet
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
    mean_speed : (n_joints,) array [rad/s] or None
        Mean magnitude of the speed; None where it is not kept.
    """

    joint_names: tuple[str, ...]
    position: NDArray[np.float64]
    position_range: NDArray[np.float64]
    mean_speed: NDArray[np.float64] | None = None


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


class ModesOfWindow(Protocol):
    """Modes found in a stretch of time."""

    @property
    def index(self) -> int:
        """Counts windows from 0; -1 for a whole recording."""

    @property
    def start_ns(self) -> int:
        """Time of the first sample [ns]."""

    @property
    def end_ns(self) -> int:
        """Time just after the last sample [ns]."""

    @property
    def modes(self) -> ModeSet:
        """Of the structure, with ids tracked over windows."""


class ResultOfWindow(ModesOfWindow, Protocol):
    """A window as the identifier, or a command, returns it."""

    @property
    def harmonics(self) -> ModeSet:
        """Lines of machines and drives."""

    @property
    def quality(self) -> DataQuality:
        """Health of the data."""

    @property
    def pose(self) -> Pose | None:
        """Where the robot was; None without joint states."""
