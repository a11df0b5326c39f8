"""One mode followed over windows."""

from dataclasses import dataclass, field
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.mode import Mode
from oma_identifier.tracking.thresholds import TRACKING


@dataclass(frozen=True, slots=True)
class Expectation:
    """Where a track expects its mode.

    Parameters
    ----------
    frequency_hz : float [Hz]
        Mean.
    relative_std : float
        Standard deviation over the mean, without that of the estimate to come.
    place_std : float
        The part of it that comes from not knowing the pose.
    """

    frequency_hz: float
    relative_std: float
    place_std: float


@dataclass(slots=True)
class Place:
    """What a track knows of one pose.

    Parameters
    ----------
    joints : (n_joints,) array [rad]
        The pose.
    offset : float
        Logarithm of the frequency there over the track's level.
    variance : float
        Of the offset.
    told : float
        Logarithm of the frequency [ln Hz] that a map predicts there; NaN: none did.
    """

    joints: NDArray[np.float64]
    offset: float
    variance: float
    told: float = math.nan


@dataclass(frozen=True, slots=True)
class Prior:
    """What a map says of a track's mode at the pose where the arm is.

    Parameters
    ----------
    frequency_hz : float [Hz]
        Mean.
    relative_std : float
        Standard deviation over the mean.
    """

    frequency_hz: float
    relative_std: float


@dataclass(slots=True)
class Track:
    """A mode's memory: a level that drifts everywhere alike, and an offset of each pose.

    The logarithm of the frequency is level plus offset of the pose; the level is a random walk
    whose step is learned, and both are followed by a Kalman filter.

    Parameters
    ----------
    id : int
        Given to every mode linked to it.
    frequency_hz, damping_ratio : float [Hz], [-]
        As last seen.
    level, variance : float
        Logarithm of the frequency in the place first seen [ln Hz], and its variance.
    wander : float
        Standard deviation of the level's step from one window to the next.
    shape : (n_channels,) complex array
        Running mean, aligned in phase.
    channel_names : tuple of str
        Entries of the shape.
    n_seen, missed : int
        Windows it was found in; windows since.
    places : list of Place
        Offsets by pose.
    companions : dict of int to int
        In how many windows this one was found beside another, by its id.
    """

    id: int
    frequency_hz: float = math.nan
    damping_ratio: float = math.nan
    level: float = math.nan
    variance: float = 0.0
    wander: float = TRACKING.wander
    shape: NDArray[np.complex128] = field(default_factory=lambda: np.empty(0, dtype=complex))
    channel_names: tuple[str, ...] = ()
    n_seen: int = 0
    missed: int = 0
    places: list[Place] = field(default_factory=list)
    companions: dict[int, int] = field(default_factory=dict)
    predicted: dict[int, int] = field(default_factory=dict)
    last_joints: NDArray[np.float64] | None = None

    @property
    def predicted_id(self) -> int:
        """Id of this mode in a map; 0: none is known."""
        return max(self.predicted, key=lambda each: self.predicted[each], default=0)

    def has_moved(self, joints: NDArray[np.float64] | None) -> bool:
        """Tell whether the arm was elsewhere when the mode was seen last."""
        before = self.last_joints
        if before is None or joints is None or len(before) != len(joints):
            return False
        return float(np.max(np.abs(before - joints), initial=0.0)) > TRACKING.same_pose_rad

    def observe(
        self,
        mode: Mode,
        joints: NDArray[np.float64] | None,
        channel_names: tuple[str, ...],
        prior: Prior | None = None,
    ) -> None:
        """Learn from a mode linked to this track."""
        self._learn_frequency(math.log(mode.frequency_hz), relative_std(mode) ** 2, joints, prior)
        if prior is not None and self.has_moved(joints):
            # The memory of the shape is of another pose, and a map tells whose shape this is.
            self.channel_names = ()
        self.last_joints = None if joints is None else joints.copy()
        self.frequency_hz = mode.frequency_hz
        self.damping_ratio = mode.damping_ratio
        self._learn_shape(mode.shape, channel_names)
        self.n_seen += 1
        self.missed = 0

    def expected(
        self, joints: NDArray[np.float64] | None, prior: Prior | None = None
    ) -> Expectation:
        """Return where the mode should be in a pose."""
        place = self._place(joints, prior)
        return Expectation(
            math.exp(self.level + place.offset),
            math.sqrt(self.drifted + place.variance),
            math.sqrt(place.variance),
        )

    @property
    def drifted(self) -> float:
        """Variance of the level in the window to come."""
        steps = 1.0 + min(self.missed, TRACKING.longest_drift)
        return self.variance + max(self.wander, TRACKING.least_wander) ** 2 * steps

    def _learn_frequency(
        self,
        value: float,
        noise: float,
        joints: NDArray[np.float64] | None,
        prior: Prior | None,
    ) -> None:
        if not self.n_seen:
            self.level, self.variance = value, noise
            if joints is not None:
                self.places = [Place(joints.copy(), 0.0, 0.0, _told(prior))]
            return
        place, drifted = self._place(joints, prior), self.drifted
        innovation = value - self.level - place.offset
        known = drifted + place.variance + noise
        if self.missed == 0:
            excess = innovation**2 - (known - max(self.wander, TRACKING.least_wander) ** 2)
            squared = (
                1.0 - TRACKING.forget_wander
            ) * self.wander**2 + TRACKING.forget_wander * max(excess, 0.0)
            self.wander = min(math.sqrt(squared), TRACKING.most_wander)
        self.level += drifted / known * innovation
        self.variance = drifted * (1.0 - drifted / known)
        place.offset += place.variance / known * innovation
        place.variance *= 1.0 - place.variance / known
        if joints is not None and not any(place is old for old in self.places):
            self.places.append(place)
            del self.places[: -TRACKING.most_places]

    def _place(self, joints: NDArray[np.float64] | None, prior: Prior | None) -> Place:
        """Return what is known of a pose; of a new one what the nearest known one tells, or a map.

        A map tells the change from the known pose, so that what it has wrong at both drops out.
        """
        if joints is None:
            return Place(np.empty(0), 0.0, 0.0)
        known = [place for place in self.places if len(place.joints) == len(joints)]
        if not known:
            return Place(joints.copy(), 0.0, 0.0)
        away = [float(np.max(np.abs(place.joints - joints), initial=0.0)) for place in known]
        nearest = int(np.argmin(away))
        if away[nearest] <= TRACKING.same_pose_rad:
            near = known[nearest]
            if math.isnan(near.told):
                near.told = _told(prior)
            return near
        near, told = known[nearest], _told(prior)
        unknown = (TRACKING.pose_wander_per_rad * away[nearest]) ** 2
        if prior is not None and math.isfinite(near.told):
            changed = 2.0 * max(prior.relative_std, TRACKING.least_std) ** 2
            if changed < unknown:
                offset = near.offset + told - near.told
                return Place(joints.copy(), offset, near.variance + changed, told)
        return Place(joints.copy(), near.offset, near.variance + unknown, told)

    def _learn_shape(self, shape: NDArray[np.complex128], channel_names: tuple[str, ...]) -> None:
        unit = shape / max(float(np.linalg.norm(shape)), 1e-300)
        if self.channel_names != channel_names or len(self.shape) != len(unit):
            self.shape, self.channel_names = unit, channel_names
            return
        product = np.vdot(unit, self.shape)
        turn = product / abs(product) if product != 0.0 else 1.0
        mixed = (1.0 - TRACKING.forget) * self.shape + TRACKING.forget * turn * unit
        self.shape = mixed / max(float(np.linalg.norm(mixed)), 1e-300)

    def to_json(self) -> dict[str, object]:
        """Return the memory as plain data."""
        return {
            'id': self.id,
            'frequency_hz': self.frequency_hz,
            'damping_ratio': self.damping_ratio,
            'level': self.level,
            'variance': self.variance,
            'wander': self.wander,
            'shape_real': self.shape.real.tolist(),
            'shape_imag': self.shape.imag.tolist(),
            'channel_names': list(self.channel_names),
            'n_seen': self.n_seen,
            'missed': self.missed,
            'places': [
                [
                    place.joints.tolist(),
                    place.offset,
                    place.variance,
                    None if math.isnan(place.told) else place.told,
                ]
                for place in self.places
            ],
            'predicted': [list(item) for item in sorted(self.predicted.items())],
            'companions': [list(item) for item in sorted(self.companions.items())],
        }


def _told(prior: Prior | None) -> float:
    return math.nan if prior is None else math.log(prior.frequency_hz)


def relative_std(mode: Mode) -> float:
    """Return a mode's standard deviation of frequency over its frequency, within belief.

    A mode that is hardly determined must not link to anything near and far.
    """
    value = mode.frequency_std_hz / mode.frequency_hz
    return (
        min(max(value, TRACKING.least_std), TRACKING.most_std)
        if math.isfinite(value)
        else TRACKING.unknown_std
    )
