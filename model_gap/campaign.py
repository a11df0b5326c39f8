"""What a campaign is once it has been read: records of known motion and measured acceleration."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from modal_core.channel import SensorLayout

Array = NDArray[np.float64]


@dataclass(frozen=True)
class GapRecord:
    """One recording at one pose and one amplitude level, on one uniform time grid.

    Parameters
    ----------
    name : str
        File or folder it came from.
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
    heldout : bool or None
        As the campaign says; None: the workflow decides.
    """

    name: str
    pose: Array
    level: str
    sample_rate_hz: float
    acceleration: Array
    motor_acceleration: Array
    motor_velocity: Array
    motor_shift: Array
    heldout: bool | None = None


@dataclass(frozen=True)
class Campaign:
    """All records with one sensor layout.

    Parameters
    ----------
    records : tuple of GapRecord
        In the order of campaign.yaml.
    layout : SensorLayout
        Sensors whose channels are the columns of the accelerations.
    joint_names : tuple of str
        Columns of the motor motion.
    excitation : str
        What the known motion was taken from.
    notes : tuple of str
        What was assumed, left out or limits the comparison.
    """

    records: tuple[GapRecord, ...]
    layout: SensorLayout
    joint_names: tuple[str, ...]
    excitation: str = 'joint states'
    notes: tuple[str, ...] = field(default=())
