"""Modes of an arm that moves: those of the map at each pose, each with an id that lasts."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from workspace_map.following import Followed, followed_from
from workspace_map.predicted import PredictedModes
from workspace_map.workspace_map import WorkspaceMap

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ModesHere:
    """Modes at the pose where the arm is.

    Parameters
    ----------
    predicted : PredictedModes
        With their covariance.
    ids : (n_modes,) int array
        From 1; of the same mode at every pose of the motion.
    """

    predicted: PredictedModes
    ids: NDArray[np.intp]


class MotionModes:
    """Follows the modes of a map along the motion of its arm.

    Ids are numbers by frequency at the pose that was measured first, so that a map gives the same
    ones whenever it is loaded, up to modes that cross on the way to where the arm is first seen.

    Parameters
    ----------
    known : WorkspaceMap
        The map.
    """

    def __init__(self, known: WorkspaceMap) -> None:
        self.known = known
        self._followed: Followed | None = None
        self._next_id = 1

    def at(self, q: ArrayLike) -> ModesHere:
        """Return the modes at the arm's next pose, (n_joints,) serial angles [rad].

        Raises
        ------
        MapError
            The map does not know enough of it.
        ModelError
            It is outside the robot's range.
        """
        angles = self.known.arm.model.check_pose(q)
        predicted = self.known.predict_surely(angles)
        before = self._followed or followed_from(self.known, self._home())
        self._followed = self._numbered(before.moved(angles))
        return ModesHere(predicted, self._followed.ids[: len(predicted)])

    def _numbered(self, found: Followed) -> Followed:
        """Give modes that come from above the band numbers of their own."""
        self._next_id = max(self._next_id, int(np.max(found.ids, initial=0)) + 1)
        new = np.flatnonzero(found.ids == 0)
        ids = found.ids.copy()
        ids[new] = self._next_id + np.arange(len(new))
        self._next_id += len(new)
        return replace(found, ids=ids)

    def _home(self) -> Array:
        if self.known.measured:
            return self.known.measured[0].q
        return self.known.arm.model.usual_pose()
