"""Rigid-motion removal: what the sensors of a rigid arm would read is subtracted.

The joints move while the arm vibrates, so an accelerometer carries the acceleration of its link,
the turning direction of gravity, and a gyroscope the turning itself.  All follow from the joint
states through the robot's model; what is left is vibration and noise.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
import math

import numpy as np
from numpy.typing import NDArray
from scipy.signal import welch

from modal_core.channel import Channel
from modal_core.measurements import JointSamples, NANOSECONDS_PER_SECOND
from modal_core.samples import Samples
from oma_identifier.joint_motion import joint_motion, JointMotion
from oma_identifier.resample import half_width, interpolate
from oma_identifier.robot_motion import in_model_order, RobotMotion

MOST_OUTSIDE_S = 0.25
"""Time at either end of a window that the joint states may leave uncovered."""
WORSE = 1.5
"""Times its power below the vibrations that removal may leave on a channel the model fits."""
STANDS_OUT = 6.0
"""Times the power that the prediction's own error leaves, that a mode must have."""
MISMATCH = 'rigid_motion_mismatch'
SAME_GRID = 0.01
"""Steps between the samples of two windows that pass for none."""
SLOW_HZ = 2.0
"""Below, rigid motion outweighs vibration: where model and sensor are compared."""


@dataclass(frozen=True, slots=True)
class RigidRemoval:
    """Samples without rigid motion.

    Parameters
    ----------
    samples : Samples
        What is left; the mean, gravity at rest, included in what was taken out.
    flags : dict of str to str
        By channel: ``rigid_motion_mismatch`` where the prediction does not fit and nothing was
        taken out.
    motion : JointMotion or None
        The joints' motion, for the drives' orders.
    jacobian : (n_channels, n_joints) array [m/s² per rad/s²]
        Reading per joint acceleration at the mean pose; zero where nothing was taken out.
    """

    samples: Samples
    flags: dict[str, str]
    motion: JointMotion | None
    jacobian: NDArray[np.float64] | None = None

    def explains(
        self, frequency_hz: float, width_hz: float, shape: NDArray[np.complex128]
    ) -> bool:
        """Tell whether a peak is no more than what is wrong with the prediction.

        Encoder noise, differentiated twice, and motion below that noise stay in the samples.  The
        power they leave along a shape is known; a mode must stand out of it.

        Parameters
        ----------
        frequency_hz, width_hz : float [Hz]
            Place and half-power half-width of the peak.
        shape : (n_channels,) complex array [m/s²]
            Direction of the peak.
        """
        if self.motion is None or self.jacobian is None:
            return False
        unit = shape.conj() / np.linalg.norm(shape)
        blurred = np.abs(unit @ self.jacobian) ** 2 @ self.motion.error_at(frequency_hz)
        return bool(power_at(self.samples, frequency_hz, width_hz, unit) < STANDS_OUT * blurred)


class RigidMotionRemoval:
    """Subtracts rigid motion, window after window; what windows share is predicted once.

    Parameters
    ----------
    robot : RobotMotion
        The model.
    """

    def __init__(self, robot: RobotMotion) -> None:
        self._robot = robot
        self._last: _Prediction | None = None

    def __call__(self, samples: Samples, joints: JointSamples | None) -> RigidRemoval:
        """Subtract rigid motion from all channels on links the model knows.

        Parameters
        ----------
        samples : Samples
            One window.
        joints : JointSamples or None
            Joint states of the window; where they do not cover it nothing is removed.
        """
        motion = motion_of(samples, joints, self._robot)
        links = self._robot.link_names
        columns = [
            place for place, channel in enumerate(samples.channels) if channel.frame_id in links
        ]
        if motion is None or not columns:
            self._last = None
            return RigidRemoval(samples, {}, motion)
        chosen = tuple(samples.channels[column] for column in columns)
        rigid = self._predict(samples, motion, chosen)
        left, flags = samples.acceleration.copy(), {}
        jacobian = np.zeros((len(samples.channels), len(self._robot.joint_names)))
        per_acceleration = _per_acceleration(self._robot, motion, chosen)
        for place, column in enumerate(columns):
            if _fits(left[:, column], rigid[:, place], samples.sample_rate_hz):
                left[:, column] -= rigid[:, place]
                jacobian[column] = per_acceleration[place]
            else:
                flags[samples.channels[column].name] = MISMATCH
        return RigidRemoval(replace(samples, acceleration=left), flags, motion, jacobian)

    def _predict(
        self, samples: Samples, motion: JointMotion, channels: tuple[Channel, ...]
    ) -> NDArray[np.float64]:
        known = self._known(samples, channels)
        n_known = 0 if known is None else len(known)
        rows = self._readings(samples, motion, channels, n_known)
        rigid = rows if known is None else np.concatenate([known, rows])
        self._last = _Prediction(channels, samples.sample_rate_hz, samples.start_ns, rigid)
        return rigid

    def _known(
        self, samples: Samples, channels: tuple[Channel, ...]
    ) -> NDArray[np.float64] | None:
        """Return the predictions of the last window that this one begins with."""
        last = self._last
        if last is None or (last.channels, last.rate_hz) != (channels, samples.sample_rate_hz):
            return None
        passed = (samples.start_ns - last.start_ns) * last.rate_hz / NANOSECONDS_PER_SECOND
        first = round(passed)
        shared = last.rows[first : first + len(samples.acceleration)]
        if first < 0 or abs(passed - first) > SAME_GRID or len(shared) == 0:
            return None
        return shared

    def _readings(
        self, samples: Samples, motion: JointMotion, channels: tuple[Channel, ...], first: int
    ) -> NDArray[np.float64]:
        """Return the readings of a rigid arm at the samples from ``first`` on."""
        step_ns = NANOSECONDS_PER_SECOND / samples.sample_rate_hz
        grid_ns = np.arange(first, len(samples.acceleration)) * step_ns
        place = (grid_ns - motion.origin_ns) / motion.period_ns
        place = np.clip(place, 0.0, len(motion.position) - 1.0)
        if len(place) == 0:
            return np.empty((0, len(channels)))
        cutoff = min(1.0, motion.period_ns / step_ns)
        margin = half_width(cutoff) + 1
        low = max(0, math.floor(place[0]) - margin)
        high = math.ceil(place[-1]) + margin + 1
        part = slice(low, high)
        readings = self._robot.rigid_acceleration(
            motion.position[part], motion.velocity[part], motion.acceleration[part], channels
        )
        return interpolate(np.asarray(readings), place - low, cutoff)


@dataclass(frozen=True, slots=True)
class _Prediction:
    channels: tuple[Channel, ...]
    rate_hz: float
    start_ns: int
    rows: NDArray[np.float64]


def power_at(
    samples: Samples, frequency_hz: float, width_hz: float, unit: NDArray[np.complex128]
) -> float:
    """Return the power spectral density along a direction near a frequency [(m/s²)²/Hz]."""
    signal = (samples.acceleration - samples.acceleration.mean(axis=0)) @ unit
    rate = samples.sample_rate_hz
    length = min(len(signal), max(64, round(4.0 * rate / max(width_hz, 1e-3))))
    frequency, density = welch(signal, rate, nperseg=length, return_onesided=False)
    near = np.abs(np.abs(frequency) - frequency_hz) <= max(width_hz, 1.0 * rate / length)
    return float(2.0 * density[near].mean()) if near.any() else math.inf


def _per_acceleration(
    robot: RobotMotion, motion: JointMotion, channels: Sequence[Channel]
) -> NDArray[np.float64]:
    pose = np.tile(motion.position.mean(axis=0), (len(robot.joint_names) + 1, 1))
    unit = np.vstack([np.zeros(len(robot.joint_names)), np.eye(len(robot.joint_names))])
    readings = np.asarray(robot.rigid_acceleration(pose, 0.0 * pose, unit, channels))
    return np.asarray((readings[1:] - readings[0]).T)


def motion_of(
    samples: Samples, joints: JointSamples | None, robot: RobotMotion
) -> JointMotion | None:
    """Return the motion of the model's joints; None where joint states do not tell."""
    position = None if joints is None else in_model_order(joints, robot)
    if joints is None or position is None:
        return None
    motion = joint_motion(joints.stamp_ns, position, samples.start_ns)
    if motion is None:
        return None
    last_ns = motion.origin_ns + len(motion.position) * motion.period_ns
    least_ns = samples.duration_s * NANOSECONDS_PER_SECOND - MOST_OUTSIDE_S * 1e9
    if motion.origin_ns > MOST_OUTSIDE_S * 1e9 or last_ns < least_ns:
        return None
    return motion


def _fits(
    measured: NDArray[np.float64], rigid: NDArray[np.float64], sample_rate_hz: float
) -> bool:
    """Tell whether removal does not add slow motion to a channel."""
    width = max(1, round(sample_rate_hz / (2.0 * SLOW_HZ)))
    n = len(measured) // width
    if n < 3:
        return True
    slow = np.column_stack([measured, measured - rigid])[: n * width]
    means = slow.reshape(n, width, 2).mean(axis=1)
    before, after = means.var(axis=0)
    return bool(after <= WORSE * before)
