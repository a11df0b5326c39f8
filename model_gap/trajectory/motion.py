"""What a recording tells below the first resonance: motion, torque, twist at one slow rate."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.signal import butter, sosfiltfilt

from model_gap.trajectory.noise import noise_in_band
from model_gap.trajectory.recording import EncoderRecording
from structural_model import FlexibleJointModel

Array = NDArray[np.float64]
# A smooth motion of a large arm has little above 5 Hz, its first resonances lie above 8 Hz; what
# a drive's torque shows beyond is its controller's noise.
BAND_HZ = 10.0
ORDER = 4
# Twice the band: at its half the filter leaves a quarter of the power, above next to nothing.
RATE_HZ = 2.0 * BAND_HZ
# Where a recording is cut off in motion the filter has to guess for three of its periods.
EDGE_S = 3.0 / BAND_HZ
# Of delays below it the speed does not change.
SHORTEST_S = 1e-6


@dataclass(frozen=True)
class Motion:
    """One recording, low-passed without delay and thinned.

    Parameters
    ----------
    name : str
        Of the recording.
    joint_rad, rate, acceleration : (n, n_joints) array [rad], [rad/s], [rad/s²]
        Serial joint motion of the motor side.
    torque_nm : (n, n_joints) array [N m]
        Of the drives, behind the gear (times the gear ratio).
    twist_rad : (n, n_encoders) array [rad]
        Motor minus link position.
    encoders : tuple of int
        Joints with an encoder behind the gear.
    path_rad, path_rate : (m, n_joints) array [rad], [rad/s]
        Controller axes at the recording's own rate, for what remembers its past.
    sample_rate_hz : float [Hz]
        Of these.
    torque_noise_nm : (n_joints,) array [N m]
        What noise leaves of itself in ``torque_nm``, rms.
    twist_noise_rad : (n_encoders,) array [rad]
        The same of ``twist_rad``.
    """

    name: str
    joint_rad: Array
    rate: Array
    acceleration: Array
    torque_nm: Array
    twist_rad: Array
    encoders: tuple[int, ...]
    path_rad: Array
    path_rate: Array
    sample_rate_hz: float
    torque_noise_nm: Array
    twist_noise_rad: Array

    @property
    def count(self) -> int:
        """How many samples there are."""
        return len(self.joint_rad)

    def speed_over(self, delay_s: float) -> Array:
        """Return the mean speed of the controller axes over a time before now, thinned."""
        if abs(delay_s) < SHORTEST_S:
            return kept(self.path_rate, self.sample_rate_hz)
        time = np.arange(len(self.path_rad)) / self.sample_rate_hz
        before = self._path(np.clip(time - delay_s, time[0], time[-1]))
        return kept((self.path_rad - before) / delay_s, self.sample_rate_hz)

    @cached_property
    def _path(self) -> CubicSpline:
        return CubicSpline(np.arange(len(self.path_rad)) / self.sample_rate_hz, self.path_rad)

    def slow(self, values: Array) -> Array:
        """Return a series at the recording's rate filtered and thinned like the torque."""
        return kept(low_passed(values, self.sample_rate_hz), self.sample_rate_hz)


def low_passed(values: Array, rate_hz: float) -> Array:
    """Return a series without what is above the band, without delay, (n, ...)."""
    return np.asarray(sosfiltfilt(filter_of(rate_hz), values, axis=0))


def filter_of(rate_hz: float) -> Array:
    """Return the filter, run forward and backward, as second-order sections."""
    return np.asarray(butter(ORDER, min(BAND_HZ, 0.45 * rate_hz), fs=rate_hz, output='sos'))


def kept(values: Array, rate_hz: float) -> Array:
    """Return every so many-th sample, without the ends."""
    edge = round(EDGE_S * rate_hz)
    return values[edge : len(values) - edge : max(1, round(rate_hz / RATE_HZ))]


def motion_of(record: EncoderRecording, model: FlexibleJointModel, start: Array) -> Motion:
    """Return what a recording tells of the motion below the first resonance.

    Parameters
    ----------
    record : EncoderRecording
        Motor positions belong to controller axes.
    model : FlexibleJointModel
        Gear ratios and axis coupling.
    start : (n_joints,) array [rad]
        Serial angles at which the positions are zero.
    """
    rate_hz = record.sample_rate_hz
    first = record.motor_rad[0]
    path = low_passed(record.motor_rad - first, rate_hz) + first
    speed = np.gradient(path, 1.0 / rate_hz, axis=0)
    gears = np.array([joint.drive.gear_ratio for joint in model.spec.joints])
    serial = [
        kept(np.asarray(model.axes.to_serial(values)), rate_hz)
        for values in (path, speed, np.gradient(speed, 1.0 / rate_hz, axis=0))
    ]
    used = list(record.encoders)
    twist = (record.motor_rad - record.link_rad)[:, used]
    torque = record.torque_nm * gears
    return Motion(
        name=record.name,
        joint_rad=serial[0] + start,
        rate=serial[1],
        acceleration=serial[2],
        torque_nm=kept(low_passed(torque, rate_hz), rate_hz),
        twist_rad=kept(low_passed(twist, rate_hz), rate_hz),
        encoders=record.encoders,
        path_rad=path,
        path_rate=speed,
        sample_rate_hz=rate_hz,
        torque_noise_nm=noise_in_band(torque, rate_hz, filter_of(rate_hz)),
        twist_noise_rad=noise_in_band(twist, rate_hz, filter_of(rate_hz)),
    )
