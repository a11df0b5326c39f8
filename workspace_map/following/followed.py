"""Ids of modes along a motion: an id belongs to a shape, which is carried from pose to pose.

Modes whose half-power bands touch are one subspace: a hair of stiffness decides how their shapes
are mixed there.  Within it shapes are carried on without turning in it; once the bands part, an
id goes to the mode that has most of its shape.  Where that is not clear, the id is undecided.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from workspace_map.arm import local_modes, LocalModes
from workspace_map.fit import BEYOND_BAND, frequency_std, ROUGH_STD
from workspace_map.following.carrying import Carried, carried_on
from workspace_map.measured_pose import MeasuredPose
from workspace_map.pairing import LEAST_LIKE, likeness, pair
from workspace_map.rows import aligned
from workspace_map.workspace_map import WorkspaceMap

Array = NDArray[np.float64]
LARGEST_STEP_RAD = np.deg2rad(2.0)
"""Between poses that are compared: a mode's shape changes little, as in the planner."""
SURE = 0.8
"""Share of a shape, or of the likeness of the two likeliest, that decides an id."""


@dataclass(frozen=True)
class Named:
    """Ids of measured modes.

    Parameters
    ----------
    ids : (n_modes,) int array
        The likeliest; 0: none of those expected.
    sure : (n_modes,) bool array
        Whether the id is stated; where not, it is undecided.
    """

    ids: NDArray[np.intp]
    sure: NDArray[np.bool_]


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
    carried : Carried or None
        The shapes that the ids belong to; None: those of the modes.
    """

    known: WorkspaceMap
    modes: LocalModes
    ids: NDArray[np.intp]
    carried: Carried | None = field(default=None, repr=False)

    @property
    def shapes(self) -> Carried:
        """What the ids belong to, one per mode."""
        return self.carried or Carried.of(self.modes)

    def moved(self, q: Array) -> 'Followed':
        """Return the modes at another pose, followed along the straight way in joint angles."""
        start = self.modes.arm.q
        count = max(1, int(np.ceil(np.max(np.abs(q - start)) / LARGEST_STEP_RAD)))
        modes, ids, carried = self.modes, self.ids, self.shapes
        for step in range(1, count + 1):
            modes = modes_at(self.known, start + (q - start) * step / count)
            came, carried = carried_on(carried, modes)
            ids = np.where(came < 0, 0, ids[came])
        return Followed(self.known, modes, ids, carried)

    def ids_of(self, measured: MeasuredPose) -> NDArray[np.intp]:
        """Return the id of each measured mode; 0: none of those expected, or undecided."""
        found = self.named(measured)
        return np.where(found.sure, found.ids, 0)

    def named(self, measured: MeasuredPose) -> Named:
        """Return the id of each measured mode by its whole shape, and whether it is sure."""
        carried = self.shapes
        # A mode that the map has wrong by more than its σ still has its shape.
        std = frequency_std(self.known.arm, self.modes, self.known.fitted.structure)
        like = likeness(
            measured,
            carried.frequency_hz,
            self.modes.arm.channels @ carried.shapes,
            np.hypot(std, ROUGH_STD),
        )
        rows, columns = linear_sum_assignment(-like)
        kept = like[rows, columns] >= LEAST_LIKE
        rows, columns = rows[kept], columns[kept]
        best = like[rows, columns]
        rivals = like[rows]
        rivals[np.arange(len(rows)), columns] = 0.0
        clear = best / (best + rivals.max(axis=1, initial=0.0))
        ids = np.zeros(len(measured), dtype=np.intp)
        sure = np.zeros(len(measured), dtype=bool)
        ids[rows] = self.ids[columns]
        sure[rows] = (clear >= SURE) & (carried.share[columns] >= SURE) & (ids[rows] > 0)
        return Named(ids, sure)


def followed_from(known: WorkspaceMap, q: Array, measured: MeasuredPose | None = None) -> Followed:
    """Return the modes at the pose where a motion begins, numbered by frequency.

    Parameters
    ----------
    known : WorkspaceMap
        The map.
    q : (n_joints,) array [rad]
        Where the motion begins.
    measured : MeasuredPose, optional
        Modes that were measured there: they have the numbers, and where bands touch their shapes
        say how the modes are mixed.
    """
    modes = modes_at(known, q)
    if measured is None:
        return Followed(known, modes, np.arange(1, modes.n + 1))
    std = np.hypot(frequency_std(known.arm, modes, known.fitted.structure), ROUGH_STD)
    found, expected = pair(measured, modes, std)
    ids = np.zeros(modes.n, dtype=np.intp)
    ids[expected] = found + 1
    ids[ids == 0] = len(measured) + 1 + np.arange(modes.n - len(expected))
    return Followed(known, modes, ids, _mixed_as(measured, found, modes, expected))


def _mixed_as(
    measured: MeasuredPose, found: NDArray[np.intp], modes: LocalModes, expected: NDArray[np.intp]
) -> Carried:
    """Return the shapes of expected modes, turned within subspaces to the measured ones."""
    turn = np.eye(modes.n)
    turn[np.ix_(expected, expected)] = aligned(measured.shapes[:, found], modes, expected).turn
    return Carried.of(modes).turned(turn)


def modes_at(known: WorkspaceMap, q: Array) -> LocalModes:
    """Return the expected modes of a pose, somewhat beyond the band too."""
    return local_modes(known.arm.at(q), known.state(q), BEYOND_BAND * known.highest_hz)
