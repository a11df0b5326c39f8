"""Where each link stands in the link before it: what viewers of robots draw by."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
import pinocchio as pin

from structural_model.description import RigidRobot


@dataclass(frozen=True, slots=True, eq=False)
class LinkPlace:
    """Where a link stands in its parent.

    Parameters
    ----------
    parent, child : str
        Links.
    position : (3,) array [m]
        Of the child's origin.
    quaternion : (4,) array
        x, y, z, w: from the child's axes to the parent's.
    """

    parent: str
    child: str
    position: NDArray[np.float64]
    quaternion: NDArray[np.float64]


class FrameTree:
    """The links of a robot as a tree of frames.

    Parameters
    ----------
    robot : RigidRobot
        The arm.
    """

    def __init__(self, robot: RigidRobot) -> None:
        self._model, self._data = robot.model, robot.model.createData()
        frames = robot.model.frames
        self._moving: list[tuple[int, int]] = []
        self._fixed: list[tuple[int, int]] = []
        for number, frame in enumerate(frames):
            joint = frames[frame.parentFrame]
            # The first frame is the universe: what hangs on it is the root.
            if frame.type != pin.FrameType.BODY or frame.parentFrame == 0:
                continue
            fixed = joint.type == pin.FrameType.FIXED_JOINT
            (self._fixed if fixed else self._moving).append((joint.parentFrame, number))

    def moving(self, q: ArrayLike) -> tuple[LinkPlace, ...]:
        """Return the links behind joints at serial joint angles q [rad]."""
        return tuple(self._places(np.asarray(q, dtype=float), self._moving))

    def fixed(self) -> tuple[LinkPlace, ...]:
        """Return the links that are fixed to others."""
        return tuple(self._places(pin.neutral(self._model), self._fixed))

    def _places(self, q: NDArray[np.float64], pairs: list[tuple[int, int]]) -> Iterator[LinkPlace]:
        pin.framesForwardKinematics(self._model, self._data, q)
        for parent, child in pairs:
            place = self._data.oMf[parent].actInv(self._data.oMf[child])
            yield LinkPlace(
                parent=self._model.frames[parent].name,
                child=self._model.frames[child].name,
                position=np.array(place.translation),
                quaternion=np.array(pin.Quaternion(place.rotation).coeffs()),
            )
