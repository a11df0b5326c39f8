"""Modes over windows: where each was found, and whether it moves with the pose of the robot."""

from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.mode import Mode
from modal_core.window import ResultOfWindow
from oma_identifier.tracking import relative_std, TRACKING

SURPRISE = 3.0


@dataclass(frozen=True, slots=True)
class ModeTrack:
    """One mode over all windows.

    Parameters
    ----------
    id : int
        Of the mode.
    n_windows, n_poses : int
        Windows it was found in; poses of the robot among them, 0 where they are not known.
    lowest_hz, highest_hz : float [Hz]
        Where it moves with the pose: means of the poses; otherwise of single windows.
    moves_with_pose : bool
        Its frequencies in different poses differ by more than three standard deviations.
    """

    id: int
    n_windows: int
    n_poses: int
    lowest_hz: float
    highest_hz: float
    moves_with_pose: bool

    def words(self) -> str:
        """Say how far it moves."""
        return (
            f'mode {self.id} moves with the pose: {self.lowest_hz:.4g} to {self.highest_hz:.4g} Hz'
            f' in {self.n_poses} poses'
        )


@dataclass(frozen=True, slots=True)
class _Mean:
    frequency_hz: float
    std_hz: float


def mode_tracks(windows: Sequence[ResultOfWindow]) -> list[ModeTrack]:
    """Return one track per id, by id."""
    poses: list[NDArray[np.float64]] = []
    seen: dict[int, dict[int, list[Mode]]] = {}
    for window in windows:
        place = -1
        if window.pose is not None:
            place = _place(np.asarray(window.pose.position, dtype=float), poses)
        for mode in window.modes:
            seen.setdefault(mode.id, {}).setdefault(place, []).append(mode)
    return [_track(number, seen[number]) for number in sorted(seen) if number > 0]


def _place(position: NDArray[np.float64], poses: list[NDArray[np.float64]]) -> int:
    """Return the number of a pose, a new one where it is not close to any before."""
    for number, known in enumerate(poses):
        near = len(known) == len(position) and np.all(
            np.abs(known - position) <= TRACKING.same_pose_rad
        )
        if near:
            return number
    poses.append(position)
    return len(poses) - 1


def _track(number: int, places: dict[int, list[Mode]]) -> ModeTrack:
    every = [mode.frequency_hz for modes in places.values() for mode in modes]
    known = [_mean(modes) for place, modes in sorted(places.items()) if place >= 0]
    lowest, highest = min(every), max(every)
    moves = False
    if len(known) > 1:
        low = min(known, key=lambda mean: mean.frequency_hz)
        high = max(known, key=lambda mean: mean.frequency_hz)
        apart = math.hypot(low.std_hz, high.std_hz)
        # The farthest two of many lie apart by chance: as in a Bonferroni correction.
        pairs = len(known) * (len(known) - 1) / 2.0
        moves = high.frequency_hz - low.frequency_hz > apart * math.sqrt(
            SURPRISE**2 + 2.0 * math.log(pairs)
        )
        if moves:
            lowest, highest = low.frequency_hz, high.frequency_hz
    return ModeTrack(number, len(every), len(known), lowest, highest, moves)


def _mean(modes: Sequence[Mode]) -> _Mean:
    """Return the mean over the windows of a pose; windows overlap, so σ shrinks with none."""
    frequency_hz = float(np.mean([mode.frequency_hz for mode in modes]))
    relative = float(np.mean([relative_std(mode) for mode in modes]))
    return _Mean(frequency_hz, relative * frequency_hz)
