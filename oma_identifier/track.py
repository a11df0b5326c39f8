"""One mode followed over windows."""

from dataclasses import dataclass, field
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.mode import Mode

SAME_POSE_RAD = 0.05
"""Poses closer than this in every joint are the same place."""
MOST_PLACES = 500
WANDER = 0.01
"""Share of its frequency a mode may drift from one window to the next, before any is measured."""
LEAST_WANDER, MOST_WANDER = 0.002, 0.02
FORGET = 0.2
"""Weight of the newest window in the running means."""
POSE_WANDER_PER_RAD = 0.15
"""Share of the frequency per radian of the largest joint change, in a pose not seen before."""


@dataclass(frozen=True, slots=True)
class Expectation:
    """Where a track expects its mode.

    Parameters
    ----------
    frequency_hz, frequency_std_hz : float [Hz]
        Mean and standard deviation.
    """

    frequency_hz: float
    frequency_std_hz: float


@dataclass(slots=True)
class Place:
    """What a track knows of one pose.

    Parameters
    ----------
    joints : (n_joints,) array [rad]
        The pose.
    frequency_hz : float [Hz]
        Running mean there.
    """

    joints: NDArray[np.float64]
    frequency_hz: float


@dataclass(slots=True)
class Track:
    """A mode's memory.

    Parameters
    ----------
    id : int
        Given to every mode linked to it.
    frequency_hz, damping_ratio : float [Hz], [-]
        Running means.
    wander : float
        Running root mean square of the relative change of frequency from window to window.
    shape : (n_channels,) complex array
        Running mean, aligned in phase.
    channel_names : tuple of str
        Entries of the shape.
    n_seen, missed : int
        Windows it was found in; windows since.
    places : list of Place
        Frequencies by pose.
    joints : (n_joints,) array or None [rad]
        Pose it was last seen in.
    """

    id: int
    frequency_hz: float = math.nan
    damping_ratio: float = math.nan
    wander: float = WANDER
    shape: NDArray[np.complex128] = field(default_factory=lambda: np.empty(0, dtype=complex))
    channel_names: tuple[str, ...] = ()
    n_seen: int = 0
    missed: int = 0
    places: list[Place] = field(default_factory=list)
    joints: NDArray[np.float64] | None = None

    def observe(
        self, mode: Mode, joints: NDArray[np.float64] | None, channel_names: tuple[str, ...]
    ) -> None:
        """Learn from a mode linked to this track."""
        same_place = self._distance_rad(joints) <= SAME_POSE_RAD
        if self.n_seen and same_place and self.missed == 0:
            step = mode.frequency_hz / self.frequency_hz - 1.0
            wander = math.sqrt((1.0 - FORGET) * self.wander**2 + FORGET * step**2)
            self.wander = min(wander, MOST_WANDER)
        self.frequency_hz = mode.frequency_hz
        self.damping_ratio = mode.damping_ratio
        self._learn_shape(mode.shape, channel_names)
        self.n_seen += 1
        self.missed = 0
        self.joints = joints
        if joints is not None:
            self._learn_place(joints, mode.frequency_hz)

    def expected(self, joints: NDArray[np.float64] | None) -> Expectation:
        """Return where the mode should be in a pose."""
        base, moved = self.frequency_hz, self._distance_rad(joints)
        place = self._place(joints)
        if place is not None:
            base, moved = place.frequency_hz, 0.0
        drift = max(self.wander, LEAST_WANDER) * math.sqrt(1.0 + min(self.missed, 25))
        return Expectation(base, base * math.hypot(drift, POSE_WANDER_PER_RAD * moved))

    def _distance_rad(self, joints: NDArray[np.float64] | None) -> float:
        if joints is None or self.joints is None or len(joints) != len(self.joints):
            return 0.0
        return float(np.max(np.abs(joints - self.joints), initial=0.0))

    def _place(self, joints: NDArray[np.float64] | None) -> Place | None:
        if joints is None:
            return None
        for place in reversed(self.places):
            if len(place.joints) == len(joints) and np.all(
                np.abs(place.joints - joints) <= SAME_POSE_RAD
            ):
                return place
        return None

    def _learn_place(self, joints: NDArray[np.float64], frequency_hz: float) -> None:
        place = self._place(joints)
        if place is not None:
            place.frequency_hz += 0.5 * (frequency_hz - place.frequency_hz)
            return
        self.places.append(Place(joints.copy(), frequency_hz))
        del self.places[:-MOST_PLACES]

    def _learn_shape(self, shape: NDArray[np.complex128], channel_names: tuple[str, ...]) -> None:
        unit = shape / max(float(np.linalg.norm(shape)), 1e-300)
        if self.channel_names != channel_names or len(self.shape) != len(unit):
            self.shape, self.channel_names = unit, channel_names
            return
        product = np.vdot(unit, self.shape)
        turn = product / abs(product) if product != 0.0 else 1.0
        mixed = (1.0 - FORGET) * self.shape + FORGET * turn * unit
        self.shape = mixed / max(float(np.linalg.norm(mixed)), 1e-300)

    def to_json(self) -> dict[str, object]:
        """Return the memory as plain data."""
        return {
            'id': self.id,
            'frequency_hz': self.frequency_hz,
            'damping_ratio': self.damping_ratio,
            'wander': self.wander,
            'shape_real': self.shape.real.tolist(),
            'shape_imag': self.shape.imag.tolist(),
            'channel_names': list(self.channel_names),
            'n_seen': self.n_seen,
            'missed': self.missed,
            'places': [[place.joints.tolist(), place.frequency_hz] for place in self.places],
            'joints': None if self.joints is None else self.joints.tolist(),
        }
