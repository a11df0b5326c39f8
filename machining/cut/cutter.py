"""A milling cutter, and what of its turn is in the cut."""

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import SettingsError

Real = NDArray[np.float64]
MOST_TEETH = 64
RIGHT_ANGLE = 0.5 * math.pi


@dataclass(frozen=True, slots=True)
class Cutter:
    """Teeth evenly spaced on a cylinder (or a cone, by the lead angle).

    Parameters
    ----------
    n_teeth : int
    diameter_m : float [m]
    helix_rad : float [rad]
        Angle of the edges to the cutter's axis.
    lead_rad : float [rad]
        Angle of the edges to the machined face; a right angle for an end mill.
    runout_m : float [m]
        Distance of the cutter's centre from the spindle's axis.
    runout_rad : float [rad]
        Direction of that distance, from tooth 0.
    """

    n_teeth: int
    diameter_m: float
    helix_rad: float = 0.0
    lead_rad: float = RIGHT_ANGLE
    runout_m: float = 0.0
    runout_rad: float = 0.0

    def __post_init__(self) -> None:
        _within('number of teeth', self.n_teeth, 1, MOST_TEETH)
        _within('diameter [m]', self.diameter_m, 1e-5, 10.0)
        _within('helix angle [rad]', self.helix_rad, 0.0, 1.4)
        _within('lead angle [rad]', self.lead_rad, 0.1, RIGHT_ANGLE)
        _within('runout [m]', self.runout_m, 0.0, 0.5 * self.diameter_m)
        _within('direction of runout [rad]', self.runout_rad, -2.0 * math.pi, 2.0 * math.pi)

    @property
    def pitch_rad(self) -> float:
        """Angle between teeth [rad]."""
        return 2.0 * math.pi / self.n_teeth

    @property
    def lag_rad_m(self) -> float:
        """How far the edges lag behind per height above the tip [rad/m]."""
        return 2.0 * math.tan(self.helix_rad) / self.diameter_m

    @property
    def radii_m(self) -> Real:
        """Radius at which each tooth turns, less that of the cutter, (n_teeth,) [m]."""
        place = self.pitch_rad * np.arange(self.n_teeth)
        return np.asarray(self.runout_m * np.cos(place - self.runout_rad), float)

    def tooth_period_s(self, speed_rpm: float) -> float:
        """Return the time from tooth to tooth [s]."""
        return 60.0 / (self.n_teeth * speed_rpm)


@dataclass(frozen=True, slots=True)
class Engagement:
    """The part of a turn that cuts; angles count from the normal of the feed, with the turn.

    Parameters
    ----------
    entry_rad, exit_rad : float [rad]
        Where a tooth enters and leaves the work, 0 to pi.
    """

    entry_rad: float
    exit_rad: float

    def __post_init__(self) -> None:
        _within('entry angle [rad]', self.entry_rad, 0.0, math.pi)
        _within('exit angle [rad]', self.exit_rad, 0.0, math.pi)
        if self.exit_rad <= self.entry_rad:
            raise SettingsError(
                'the cutter leaves the work before it enters',
                found=f'{self.entry_rad:g} to {self.exit_rad:g} rad',
            )

    @classmethod
    def slot(cls) -> 'Engagement':
        """Return the engagement of a full slot."""
        return cls(0.0, math.pi)

    @classmethod
    def up(cls, immersion: float) -> 'Engagement':
        """Return that of up-milling; the radial depth is a share of the diameter."""
        _within('radial immersion', immersion, 1e-6, 1.0)
        return cls(0.0, math.acos(1.0 - 2.0 * immersion))

    @classmethod
    def down(cls, immersion: float) -> 'Engagement':
        """Return that of down-milling; the radial depth is a share of the diameter."""
        _within('radial immersion', immersion, 1e-6, 1.0)
        return cls(math.acos(2.0 * immersion - 1.0), math.pi)


def _within(what: str, value: float, low: float, high: float) -> None:
    if not low <= value <= high:
        raise SettingsError(f'{what} out of range', found=value, expected=f'{low:g} to {high:g}')
