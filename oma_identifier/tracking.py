"""Gives modes ids that stay the same from window to window."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
import math

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from modal_core.indicators import mac
from modal_core.mode import Mode, ModeSet
from modal_core.window import Pose
from oma_identifier.checkpoint import restore
from oma_identifier.track import Track

GATE = 16.0
"""Largest cost of a link: four standard deviations, or that much in shape."""
SHAPE_SPREAD = 0.05
"""1 - MAC of two estimates of one mode that costs as much as one standard deviation squared."""
LOST_AFTER = 3
"""Windows in a row a mode is missed before it is reported lost; its id is kept."""
MOST_TRACKS = 400
FORBIDDEN = 1e6
WIDEST_STEP = 0.01
"""Share of the frequency: no larger standard deviation widens the search for a link."""


@dataclass(frozen=True, slots=True)
class TrackedModes:
    """One window's modes with ids, and what changed.

    Parameters
    ----------
    modes : ModeSet
        By frequency, each with its id.
    born : tuple of int
        Ids seen for the first time.
    lost : tuple of int
        Ids that have now been missed so often that they are reported lost.
    returned : tuple of int
        Ids that were lost and are back.
    """

    modes: ModeSet
    born: tuple[int, ...] = ()
    lost: tuple[int, ...] = ()
    returned: tuple[int, ...] = ()


class ModeTracker:
    """Links the modes of successive windows by frequency, shape, uncertainty and pose.

    Every window is assigned as a whole (Hungarian algorithm): two modes that cross are told apart
    by their shapes.  A track remembers its modes per pose, so that a robot that returns to a pose
    finds the frequencies it had there.
    """

    def __init__(self) -> None:
        self.tracks: list[Track] = []
        self._next_id = 1

    def update(self, modes: ModeSet, pose: Pose | None = None) -> TrackedModes:
        """Assign ids to the modes of the next window.

        Parameters
        ----------
        modes : ModeSet
            Without ids.
        pose : Pose or None
            Where the robot was; None when unknown or when nothing moves.
        """
        joints = None if pose is None else np.asarray(pose.position, dtype=float)
        links = self._link(modes, joints)
        born, returned, numbered = [], [], []
        for row, mode in enumerate(modes):
            track = links.get(row)
            if track is None:
                track = self._birth()
                born.append(track.id)
            elif track.missed >= LOST_AFTER:
                returned.append(track.id)
            track.observe(mode, joints, modes.channel_names)
            numbered.append(replace(mode, id=track.id))
        lost = self._miss({mode.id for mode in numbered})
        return TrackedModes(
            replace(modes, modes=tuple(numbered)), tuple(born), tuple(lost), tuple(returned)
        )

    def label(self, modes: ModeSet) -> ModeSet:
        """Return the modes with the ids they have here, without learning; new ones get new ids."""
        links = self._link(modes, None)
        numbered = []
        for row, mode in enumerate(modes):
            track = links.get(row)
            if track is None:
                track = self._birth()
                track.observe(mode, None, modes.channel_names)
            numbered.append(replace(mode, id=track.id))
        return replace(modes, modes=tuple(numbered))

    def _link(self, modes: ModeSet, joints: NDArray[np.float64] | None) -> dict[int, Track]:
        if not len(modes) or not self.tracks:
            return {}
        cost = np.array(
            [
                [link_cost(track, mode, joints, modes.channel_names) for track in self.tracks]
                for mode in modes
            ]
        )
        rows, columns = linear_sum_assignment(np.minimum(cost, FORBIDDEN))
        return {
            int(row): self.tracks[column]
            for row, column in zip(rows, columns, strict=True)
            if cost[row, column] <= GATE
        }

    def _birth(self) -> Track:
        track = Track(id=self._next_id)
        self._next_id += 1
        self.tracks.append(track)
        return track

    def _miss(self, seen: Iterable[int]) -> list[int]:
        lost = []
        present = set(seen)
        for track in self.tracks:
            if track.id in present:
                continue
            track.missed += 1
            if track.missed == LOST_AFTER:
                lost.append(track.id)
        if len(self.tracks) > MOST_TRACKS:
            # The least seen and longest gone make room.
            self.tracks.sort(key=lambda track: (track.n_seen, -track.missed), reverse=True)
            del self.tracks[MOST_TRACKS:]
            self.tracks.sort(key=lambda track: track.id)
        return lost

    def to_json(self) -> dict[str, object]:
        """Return the state as plain data for a checkpoint."""
        return {
            'next_id': self._next_id,
            'tracks': [track.to_json() for track in self.tracks],
        }

    @classmethod
    def from_json(cls, data: object) -> 'ModeTracker':
        """Rebuild a tracker from :meth:`to_json`.

        Raises
        ------
        SettingsError
            The data is not a checkpoint of a tracker.
        """
        state = restore(data)
        tracker = cls()
        tracker.tracks, tracker._next_id = state.tracks, state.next_id
        return tracker


def link_cost(
    track: Track,
    mode: Mode,
    joints: NDArray[np.float64] | None,
    channel_names: tuple[str, ...],
) -> float:
    """Return how unlikely it is that a mode continues a track, as a squared distance.

    (Δf / σ)² with the uncertainty of both and the track's own wander, plus (1 - MAC) over its
    usual spread.
    """
    expected = track.expected(joints)
    # A mode that is hardly determined must not link to anything near and far.
    widest = WIDEST_STEP * mode.frequency_hz
    own = min(mode.frequency_std_hz, widest) if math.isfinite(mode.frequency_std_hz) else 0.0
    spread = math.hypot(own, expected.frequency_std_hz)
    distance = ((mode.frequency_hz - expected.frequency_hz) / spread) ** 2
    if distance > GATE:
        return FORBIDDEN
    return distance + (1.0 - _alike(track, mode, channel_names)) / SHAPE_SPREAD


def _alike(track: Track, mode: Mode, channel_names: tuple[str, ...]) -> float:
    """MAC over the channels both have; 1 when they share none."""
    if track.channel_names == channel_names:
        return float(mac(track.shape, mode.shape)[0, 0])
    shared = [name for name in channel_names if name in track.channel_names]
    if not shared:
        return 1.0
    first = track.shape[[track.channel_names.index(name) for name in shared]]
    second = mode.shape[[channel_names.index(name) for name in shared]]
    return float(mac(first, second)[0, 0])
