"""What arrives from topics and recordings, in batches: the input of the sample buffer.

Times are integer nanoseconds since the epoch, taken from message headers; nothing here reads a
clock.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

NANOSECONDS_PER_SECOND = 1_000_000_000


@dataclass(frozen=True, slots=True)
class StampedSamples:
    """Samples of one per-sample sensor (Imu, AccelStamped), in order of arrival.

    Parameters
    ----------
    source : str
        Topic the samples came on; with ``axes`` it makes the channel names.
    frame_id : str
        Link named in the headers.
    stamp_ns : (n_samples,) int64 array [ns]
        Header stamps; may jitter, repeat or run backwards.
    acceleration : (n_samples, 3) array [m/s²]
        As sent; any number of columns when ``channel_names`` names them.
    angular_velocity : (n_samples, 3) array [rad/s] or None
        From an Imu; None where the sensor has no gyroscope.
    channel_names : tuple of str
        One per column of the acceleration; empty: x, y and z of the source.
    units : tuple of str
        SI unit of each column where they are not all accelerations; empty: all are.
    """

    source: str
    frame_id: str
    stamp_ns: NDArray[np.int64]
    acceleration: NDArray[np.float64]
    angular_velocity: NDArray[np.float64] | None = None
    channel_names: tuple[str, ...] = ()
    units: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class SampleBlock:
    """One AccelerationBlock.

    Parameters
    ----------
    source : str
        Topic the block came on.
    stamp_ns : int [ns]
        Time of the first sample.
    first_index : int
        Running counter of the first sample.
    sample_rate_hz : float [Hz]
        Nominal rate.
    channel_names : tuple of str
        One per column.
    acceleration : (n_samples, n_channels) array [m/s²]
        As sent.
    units : tuple of str
        SI unit of each column where they are not all accelerations; empty: all are.
    """

    source: str
    stamp_ns: int
    first_index: int
    sample_rate_hz: float
    channel_names: tuple[str, ...]
    acceleration: NDArray[np.float32]
    units: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class JointSamples:
    """Joint states, in order of arrival.

    Parameters
    ----------
    stamp_ns : (n_samples,) int64 array [ns]
        Header stamps.
    joint_names : tuple of str
        One per column.
    position : (n_samples, n_joints) array [rad]
        Motor-side joint angles, as serial joints.
    velocity : (n_samples, n_joints) array [rad/s]
        NaN where not sent.
    effort : (n_samples, n_joints) array [N m]
        NaN where not sent.
    """

    stamp_ns: NDArray[np.int64]
    joint_names: tuple[str, ...]
    position: NDArray[np.float64]
    velocity: NDArray[np.float64]
    effort: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 0)))


Measurement = StampedSamples | SampleBlock | JointSamples
