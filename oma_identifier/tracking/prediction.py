"""What a map of the workspace expects at the poses where the arm has been, for who gives ids."""

from collections import deque
from dataclasses import dataclass
import math
import threading

import numpy as np
from numpy.typing import NDArray

from modal_core.mode import Mode, ModeSet
from modal_core.numbers.assignment import cheapest_pairs
from modal_core.numbers.indicators import mac
from modal_core.window import Pose
from oma_identifier.tracking.thresholds import TRACKING
from oma_identifier.tracking.track import relative_std

FORBIDDEN = 1e6
Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class PredictedMode:
    """One mode that is expected.

    Parameters
    ----------
    id : int
        The map's own; of the same mode at every pose.
    frequency_hz : float [Hz]
        Mean.
    relative_std : float
        Standard deviation over the mean.
    shape : (n_channels,) array
        Over the channels of the prediction.
    """

    id: int
    frequency_hz: float
    relative_std: float
    shape: Array


@dataclass(frozen=True, slots=True)
class Prediction:
    """Modes that are expected at one pose.

    Parameters
    ----------
    joint_names : tuple of str
        Joints of the pose.
    joints : (n_joints,) array [rad]
        The pose.
    channel_names : tuple of str
        Entries of the shapes.
    modes : tuple of PredictedMode
        By frequency.
    """

    joint_names: tuple[str, ...]
    joints: Array
    channel_names: tuple[str, ...]
    modes: tuple[PredictedMode, ...]

    def mode(self, number: int) -> PredictedMode | None:
        """Return the mode of an id; None where it is not expected here."""
        return next((mode for mode in self.modes if mode.id == number), None)

    def like(self, expected: PredictedMode, mode: Mode, names: tuple[str, ...]) -> float | None:
        """Return the MAC of a found mode with an expected one; None without common channels.

        Parameters
        ----------
        expected : PredictedMode
            Of this prediction.
        mode : Mode
            Found.
        names : tuple of str
            Entries of its shape.
        """
        shared = [name for name in names if name in self.channel_names]
        if not shared:
            return None
        first = expected.shape[[self.channel_names.index(name) for name in shared]]
        second = mode.shape[[names.index(name) for name in shared]]
        return float(mac(first, second)[0, 0])

    def partners(self, modes: ModeSet) -> dict[int, PredictedMode]:
        """Return which of the expected modes each found one is, by its place in the set.

        Frequencies may have drifted since the map was made, by as much as a mode may between two
        windows; the shape tells what the frequency leaves open.
        """
        if not len(modes) or not self.modes:
            return {}
        names = modes.channel_names
        cost = np.array([[self._cost(each, mode, names) for each in self.modes] for mode in modes])
        rows, columns = cheapest_pairs(np.where(cost <= TRACKING.gate, cost, FORBIDDEN))
        return {
            int(row): self.modes[column]
            for row, column in zip(rows, columns, strict=True)
            if cost[row, column] <= TRACKING.gate
        }

    def _cost(self, expected: PredictedMode, mode: Mode, names: tuple[str, ...]) -> float:
        """Return (Δf / σ)² plus 1 - MAC over its usual spread."""
        alike = self.like(expected, mode, names)
        if alike is None:
            return FORBIDDEN
        step = math.log(mode.frequency_hz / expected.frequency_hz)
        spread = math.hypot(relative_std(mode), expected.relative_std, TRACKING.wander)
        loss = mode.mac_loss if math.isfinite(mode.mac_loss) else 0.0
        return (step / spread) ** 2 + (1.0 - alike) / (TRACKING.shape_spread + loss)


class Predictions:
    """The predictions of the poses where the arm was last; told and asked from any thread."""

    def __init__(self) -> None:
        self._kept: deque[Prediction] = deque(maxlen=TRACKING.most_predictions)
        self._lock = threading.Lock()

    def add(self, prediction: Prediction) -> None:
        """Keep a prediction; a newer one of nearly the same pose replaces the last."""
        with self._lock:
            if self._kept and _distance(self._kept[-1], prediction.joints) < NEARLY_RAD:
                self._kept.pop()
            self._kept.append(prediction)

    def at(self, pose: Pose | None) -> Prediction | None:
        """Return the prediction nearest to a pose; None where none is of that place."""
        if pose is None:
            return None
        with self._lock:
            kept = [each for each in self._kept if set(each.joint_names) <= set(pose.joint_names)]
        if not kept:
            return None
        away = [_distance(each, _ordered(pose, each.joint_names)) for each in kept]
        nearest = int(np.argmin(away))
        return kept[nearest] if away[nearest] <= TRACKING.same_pose_rad else None


NEARLY_RAD = 0.1 * TRACKING.same_pose_rad


def _ordered(pose: Pose, names: tuple[str, ...]) -> Array:
    position = np.asarray(pose.position, dtype=float)
    return position[[pose.joint_names.index(name) for name in names]]


def _distance(prediction: Prediction, joints: Array) -> float:
    if len(prediction.joints) != len(joints):
        return math.inf
    return float(np.max(np.abs(prediction.joints - joints), initial=0.0))
