"""What a campaign is once it has been read: records of known motion and measured acceleration."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modal_core.channel import SensorLayout
from model_gap.campaign.thresholds import CAMPAIGN

Array = NDArray[np.float64]


@dataclass(frozen=True)
class MotionNoise:
    """Noise of the known motion: encoder steps, or whatever else is white in what was recorded.

    Parameters
    ----------
    density : (n_joints,) array [rad²/Hz] or [rad²/s²/Hz]
        Two-sided, of the recorded quantity; empty: none.
    derivatives : int
        From the recorded quantity to the acceleration: 2 for positions, 1 for velocities.
    """

    density: Array = field(default_factory=lambda: np.zeros(0))
    derivatives: int = 2

    def acceleration_density(self, omega: Array) -> Array:
        """Return the two-sided density of the acceleration's noise, (n_joints, n) [rad²/s⁴/Hz].

        Parameters
        ----------
        omega : (n,) array [rad/s]
            Where.
        """
        return np.asarray(self.density[:, None] * omega ** (2 * self.derivatives))


@dataclass(frozen=True)
class GapRecord:
    """One recording at one pose and one amplitude level, on one uniform time grid.

    Parameters
    ----------
    name : str
        File or folder it came from, as a path from the campaign's folder: one record alone has it.
    pose : (n_joints,) array [rad]
        Mean serial joint angles.
    level : str
        Amplitude level, as named in the campaign.
    sample_rate_hz : float [Hz]
        Of all arrays below.
    acceleration : (n_samples, n_channels) array [m/s²]
        Measured.
    motor_acceleration : (n_samples, n_joints) array [rad/s²]
        Motor side, from positions or velocities.
    motor_velocity : (n_samples, n_joints) array [rad/s]
        Motor side.
    motor_shift : (n_samples, n_joints) array [rad]
        Motor-side position less the pose.
    motion_noise : MotionNoise
        Of the motor side.
    heldout : bool or None
        As the campaign says; None: the workflow decides.
    start_s : float [s]
        When it begins, from the beginning of the campaign's first.
    missing : tuple of int
        Columns of the acceleration that this recording does not have; zeros stand in them.
    """

    name: str
    pose: Array
    level: str
    sample_rate_hz: float
    acceleration: Array
    motor_acceleration: Array
    motor_velocity: Array
    motor_shift: Array
    motion_noise: MotionNoise = field(default_factory=MotionNoise)
    heldout: bool | None = None
    start_s: float = 0.0
    missing: tuple[int, ...] = ()

    @property
    def recorded(self) -> NDArray[np.intp]:
        """Columns of the acceleration that this recording has."""
        return np.delete(np.arange(self.acceleration.shape[1]), self.missing)


@dataclass(frozen=True)
class Campaign:
    """All records of one robot.

    Parameters
    ----------
    records : tuple of GapRecord
        In the order of campaign.yaml.
    layout : SensorLayout
        Sensors whose channels are the columns of the accelerations: all that any recording has.
    joint_names : tuple of str
        Columns of the motor motion.
    excitation : str
        What the known motion was taken from.
    effort_recorded : bool
        Joint efforts are there in every recording.
    motion_rate_hz, motion_band_hz : float [Hz]
        Rate of the joint states, and up to where the motion is known from them; 0: what the
        slowest recording tells, whose motion is at its own rate.
    notes : tuple of str
        What was assumed, left out or limits the comparison.
    remarks : tuple of str
        What the person who recorded it wrote.
    given_layout : SensorLayout or None
        With the sensors and axes that no recording has; None: there are none.
    effects : tuple of Path
        Folders or files with effects of one's own that it needs; nothing of them is loaded.
    tolerances : dict of str to number
        How roughly the model is known, as far as the campaign says.
    """

    records: tuple[GapRecord, ...]
    layout: SensorLayout
    joint_names: tuple[str, ...]
    excitation: str = 'joint states'
    effort_recorded: bool = False
    motion_rate_hz: float = 0.0
    motion_band_hz: float = 0.0
    notes: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()
    given_layout: SensorLayout | None = None
    effects: tuple[Path, ...] = ()
    tolerances: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Take from the recordings what is not said of the motion."""
        slowest_hz = min((record.sample_rate_hz for record in self.records), default=0.0)
        if not self.motion_rate_hz:
            object.__setattr__(self, 'motion_rate_hz', slowest_hz)
        if not self.motion_band_hz:
            object.__setattr__(self, 'motion_band_hz', CAMPAIGN.usable_share * slowest_hz)

    @property
    def whole_layout(self) -> SensorLayout:
        """The layout as it was given, whether or not all of it was recorded."""
        return self.layout if self.given_layout is None else self.given_layout
