"""At what joint speed, in which pose and under which load a recording was made."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.window import Pose

SPEED, LOAD, ANGLE, NUMBER = 'joint speed [°/s]', 'load [kg]', 'joint angle [°]', 'recording'
STANDS_DEG_S = 0.05
"""Below, joints stand: what encoders wander in a tenth of a second."""
SAME_DEG = 0.5
"""Angles that differ less are one pose."""


@dataclass(frozen=True, slots=True)
class OperatingState:
    """Means over a recording.

    Parameters
    ----------
    joint_names : tuple of str
        Empty where no joint states are known.
    angle_deg, speed_deg_s : (n_joints,) array [°], [°/s]
        Of the joints; speeds are magnitudes, NaN where not known.
    load_kg : float [kg]
        NaN where it was not stated.
    """

    joint_names: tuple[str, ...]
    angle_deg: NDArray[np.float64]
    speed_deg_s: NDArray[np.float64]
    load_kg: float = math.nan

    @property
    def fastest_deg_s(self) -> float:
        """Speed of the fastest joint, 0 where all stand [°/s]."""
        known = self.speed_deg_s[np.isfinite(self.speed_deg_s)]
        if not len(known):
            return math.nan
        return float(known.max()) if known.max() > STANDS_DEG_S else 0.0

    def words(self) -> str:
        """Say the state in a line; empty where nothing is known."""
        parts = []
        if self.joint_names:
            angles = ', '.join(f'{angle + 0.0:.0f}' for angle in self.angle_deg)
            parts.append(f'pose {angles}°')
        speed = self.fastest_deg_s
        if speed > 0.0:
            joint = self.joint_names[int(np.nanargmax(self.speed_deg_s))]
            parts.append(f'{joint} at {speed:.3g} °/s')
        elif speed == 0.0:
            parts.append('at rest')
        if math.isfinite(self.load_kg):
            parts.append(f'load {self.load_kg:g} kg')
        return ', '.join(parts)


UNKNOWN_STATE = OperatingState((), np.zeros(0), np.zeros(0))


def state_of(poses: Iterable[Pose | None]) -> OperatingState:
    """Return the mean of the windows of a recording."""
    known = [pose for pose in poses if pose is not None]
    known = [pose for pose in known if pose.joint_names == known[0].joint_names]
    if not known:
        return UNKNOWN_STATE
    speeds = [pose.mean_speed for pose in known if pose.mean_speed is not None]
    n_joints = len(known[0].joint_names)
    speed = np.mean(speeds, axis=0) if speeds else np.full(n_joints, np.nan)
    angle = np.mean([pose.position for pose in known], axis=0)
    return OperatingState(known[0].joint_names, np.rad2deg(angle), np.rad2deg(speed))


def differing(states: Sequence[OperatingState]) -> list[tuple[str, list[float]]]:
    """Return what states differ in, most telling first, with the value of each state.

    The speed of the fastest joint, the load, and of the angles that which differs most; where
    nothing is known to differ the number of the recording, from 1.
    """
    found = []
    for name, values in (
        (SPEED, [state.fastest_deg_s for state in states]),
        (LOAD, [state.load_kg for state in states]),
    ):
        if np.isfinite(values).all() and np.ptp(values) > 0.0:
            found.append((name, values))
    names = {state.joint_names for state in states}
    if len(names) == 1 and states[0].joint_names:
        angles = np.array([state.angle_deg for state in states])
        joint = int(np.argmax(np.ptp(angles, axis=0)))
        if np.ptp(angles[:, joint]) > SAME_DEG:
            label = ANGLE.replace('joint', states[0].joint_names[joint])
            found.append((label, angles[:, joint].tolist()))
    return found or [(NUMBER, [float(number + 1) for number in range(len(states))])]
