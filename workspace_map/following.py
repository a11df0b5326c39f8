"""Ids of modes along a motion: each mode is followed by its shape."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from workspace_map.arm import local_modes, LocalModes
from workspace_map.fit import BEYOND_BAND, frequency_std, ROUGH_STD
from workspace_map.measured_pose import MeasuredPose
from workspace_map.pairing import pair
from workspace_map.workspace_map import WorkspaceMap

Array = NDArray[np.float64]
LARGEST_STEP_RAD = np.deg2rad(2.0)
"""Between poses that are compared: a mode's shape changes little, as in the planner."""


@dataclass(frozen=True)
class Followed:
    """Modes at a pose with ids that lasted from where a motion began.

    Parameters
    ----------
    known : WorkspaceMap
        The map.
    modes : LocalModes
        Expected at the pose, somewhat beyond the band too.
    ids : (n_modes,) int array
        Of the modes; numbers 1, 2, ... by frequency where the motion began.
    """

    known: WorkspaceMap
    modes: LocalModes
    ids: NDArray[np.intp]

    def moved(self, q: Array) -> 'Followed':
        """Return the modes at another pose, followed along the straight way in joint angles."""
        start = self.modes.arm.q
        count = max(1, int(np.ceil(np.max(np.abs(q - start)) / LARGEST_STEP_RAD)))
        modes, ids = self.modes, self.ids
        for step in range(1, count + 1):
            there = modes_at(self.known, start + (q - start) * step / count)
            ids = followed_ids(modes.shapes, ids, there.shapes)[: there.n]
            modes = there
        return Followed(self.known, modes, ids)

    def ids_of(self, measured: MeasuredPose) -> NDArray[np.intp]:
        """Return the id of each measured mode; 0: none of those expected."""
        std = frequency_std(self.known.arm, self.modes, self.known.fitted.structure)
        # A mode that the map has wrong by more than its σ still has its shape.
        found, expected = pair(measured, self.modes, np.hypot(std, ROUGH_STD))
        ids = np.zeros(len(measured), dtype=np.intp)
        ids[found] = self.ids[expected]
        return ids


def followed_from(known: WorkspaceMap, q: Array) -> Followed:
    """Return the modes at the pose where a motion begins, numbered by frequency."""
    modes = modes_at(known, q)
    return Followed(known, modes, np.arange(1, modes.n + 1))


def modes_at(known: WorkspaceMap, q: Array) -> LocalModes:
    """Return the expected modes of a pose, somewhat beyond the band too."""
    return local_modes(known.arm.at(q), known.state(q), BEYOND_BAND * known.highest_hz)


def followed_ids(before: Array, ids: NDArray[np.intp], after: Array) -> NDArray[np.intp]:
    """Return ids of the modes of a neighbouring pose; 0: none of those before.

    Parameters
    ----------
    before, after : (n_dof, n_dof) array
        Mass-normalised shapes, a column each: after⁻¹ = afterᵀ M, so that no mass is needed.
    ids : (n,) int array
        Of the lowest n before.
    """
    like = np.linalg.solve(after, before[:, : len(ids)]) ** 2
    rows, columns = linear_sum_assignment(-like)
    found = np.zeros(len(after), dtype=np.intp)
    found[rows] = ids[columns]
    return found
