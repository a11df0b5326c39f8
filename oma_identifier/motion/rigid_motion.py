"""Rigid-motion removal: what the sensors of a rigid arm would read is subtracted.

The joints move while the arm vibrates, so an accelerometer carries the acceleration of its link,
the turning direction of gravity, and a gyroscope the turning itself.  All follow from the joint
states through the robot's model, as far up as the links follow the motors (`rigid_fit`); what is
left is vibration and noise.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.channel import Channel
from modal_core.measurements import JointSamples, NANOSECONDS_PER_SECOND
from modal_core.samples import Samples
from modal_core.units import ACCELERATION, ANGULAR_VELOCITY
from oma_identifier.motion.joint_motion import joint_motion, JointMotion
from oma_identifier.motion.rigid_fit import rigid_fit, RigidFit
from oma_identifier.motion.robot_motion import in_model_order, RobotMotion
from oma_identifier.motion.sensor_check import check_sensors
from oma_identifier.motion.sensor_lag import Lag
from oma_identifier.motion.thresholds import MOTION
from oma_identifier.time_axis import half_width, interpolate

PREDICTED = (ACCELERATION, ANGULAR_VELOCITY)
"""What the model says of a rigid arm."""
MISMATCH, LATE = 'rigid_motion_mismatch', 'not_synchronous'
POSES = 32
"""Moments of a window that its mean pose is told from."""


@dataclass(frozen=True, slots=True)
class RigidRemoval:
    """Samples without rigid motion.

    Parameters
    ----------
    samples : Samples
        What is left; the mean, gravity at rest, included in what was taken out.
    flags : dict of str to str
        By channel: what its sensor is suspected of (`sensor_check`), or
        ``rigid_motion_mismatch`` where the prediction does not fit, and nothing was taken out;
        ``not_synchronous`` where its sensor has another delay than the others.
    motion : JointMotion or None
        The joints' motion, all of it, on the clock of the responses.
    fit : RigidFit or None
        Delays of the channels named by ``fitted``, and where rigid motion ends; None where nothing
        moves as a rigid arm would, and nothing was taken out.
    fitted : tuple of str
        Channels on links of the model.
    """

    samples: Samples
    flags: dict[str, str]
    motion: JointMotion | None
    fit: RigidFit | None = None
    fitted: tuple[str, ...] = ()

    @property
    def lags(self) -> dict[str, Lag]:
        """Delay against the joint states, by channel."""
        if self.fit is None:
            return {}
        rows = zip(self.fitted, self.fit.lag_s, self.fit.lag_std_s, self.fit.odd, strict=True)
        return {
            name: Lag(float(lag), float(std), float(lag - self.fit.common_lag_s) if odd else 0.0)
            for name, lag, std, odd in rows
        }


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
        self._fit: RigidFit | None = None
        self._suspected: dict[str, str] = {}
        self._fitted: tuple[tuple[Channel, ...], int] = ((), 0)

    def remove(self, samples: Samples, joints: JointSamples | None) -> RigidRemoval:
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
            place
            for place, channel in enumerate(samples.channels)
            if channel.frame_id in links and channel.unit in PREDICTED
        ]
        if joints is None or motion is None or not columns:
            self._last = None
            return RigidRemoval(samples, {}, motion)
        chosen = tuple(samples.channels[column] for column in columns)
        fit = self._compare(samples, motion, columns)
        flags = dict(self._suspected)
        if fit is None:
            self._last = None
            return RigidRemoval(samples, flags, motion)
        slow = motion_of(samples, joints, self._robot, fit.reach_hz)
        rigid = self._predict(samples, slow or motion, chosen, fit)
        left = samples.acceleration.astype(np.float64)
        for place, column in enumerate(columns):
            if samples.channels[column].name in flags:
                continue
            if not _fits(left[:, column], rigid[:, place], samples.sample_rate_hz):
                flags[samples.channels[column].name] = MISMATCH
                continue
            left[:, column] -= rigid[:, place]
            if fit.odd[place]:
                flags[samples.channels[column].name] = LATE
        clean = replace(samples, acceleration=left)
        moved = motion.delayed(float(np.median(fit.proved_lag_s)))
        return RigidRemoval(clean, flags, moved, fit, tuple(c.name for c in chosen))

    def _compare(
        self, samples: Samples, motion: JointMotion, columns: Sequence[int]
    ) -> RigidFit | None:
        """Return delay and reach, compared anew when half a window is new."""
        chosen = tuple(samples.channels[column] for column in columns)
        channels, middle_ns = self._fitted
        if channels == chosen and samples.start_ns < middle_ns and self._fit is not None:
            return self._fit
        fresh = rigid_fit(
            samples.widened(columns=columns),
            self._readings(samples, motion, chosen, 0, np.zeros(len(chosen))),
            samples.sample_rate_hz,
            [channel.sensor for channel in chosen],
        )
        known = self._fit if channels == chosen else None
        self._suspected = check_sensors(
            chosen,
            samples.acceleration[:, columns].mean(axis=0, dtype=np.float64),
            self._at_rest(motion, chosen),
            None if fresh is None else fresh.slow,
        )
        self._fitted = chosen, (samples.start_ns + samples.end_ns) // 2
        # What held before is not believed where it does not hold: clocks jump.
        if fresh is None or known is None or not _same(fresh, known):
            self._fit = fresh
        return self._fit

    def _at_rest(self, motion: JointMotion, channels: tuple[Channel, ...]) -> NDArray[np.float64]:
        """Return the mean readings of an arm that stands still at the poses of a window."""
        position = motion.position[:: len(motion.position) // POSES + 1]
        still = np.zeros_like(position)
        readings = self._robot.rigid_acceleration(position, still, still, channels)
        return np.asarray(readings.mean(axis=0))

    def _predict(
        self, samples: Samples, motion: JointMotion, channels: tuple[Channel, ...], fit: RigidFit
    ) -> NDArray[np.float64]:
        known = self._known(samples, channels, fit)
        n_known = 0 if known is None else len(known)
        rows = self._readings(samples, motion, channels, n_known, fit.proved_lag_s)
        rigid = rows if known is None else np.concatenate([known, rows])
        self._last = _Prediction(channels, samples.sample_rate_hz, samples.start_ns, rigid, fit)
        return rigid

    def _known(
        self, samples: Samples, channels: tuple[Channel, ...], fit: RigidFit
    ) -> NDArray[np.float64] | None:
        """Return the predictions of the last window that this one begins with."""
        last = self._last
        if last is None or last.fit is not fit:
            return None
        if (last.channels, last.rate_hz) != (channels, samples.sample_rate_hz):
            return None
        passed = (samples.start_ns - last.start_ns) * last.rate_hz / NANOSECONDS_PER_SECOND
        first = round(passed)
        shared = last.rows[first : first + len(samples.acceleration)]
        if first < 0 or abs(passed - first) > MOTION.same_grid or len(shared) == 0:
            return None
        return shared

    def _readings(
        self,
        samples: Samples,
        motion: JointMotion,
        channels: tuple[Channel, ...],
        first: int,
        lag_s: NDArray[np.float64],
    ) -> NDArray[np.float64]:
        """Return the readings of a rigid arm at the samples from ``first`` on."""
        step_ns = NANOSECONDS_PER_SECOND / samples.sample_rate_hz
        grid_ns = np.arange(first, len(samples.acceleration), dtype=float) * step_ns
        result = np.empty((len(grid_ns), len(channels)))
        if len(grid_ns) == 0:
            return result
        cutoff = min(1.0, motion.period_ns / step_ns)
        margin = half_width(cutoff) + 1
        # Early enough for the latest channel.
        low = float(_place(grid_ns, motion, float(lag_s.max()))[0])
        low = max(0, math.floor(low) - margin)
        part = slice(low, None)
        readings = np.asarray(
            self._robot.rigid_acceleration(
                motion.position[part], motion.velocity[part], motion.acceleration[part], channels
            )
        )
        for lag in np.unique(lag_s):
            alike = lag_s == lag
            place = _place(grid_ns, motion, float(lag)) - low
            result[:, alike] = interpolate(readings[:, alike], place, cutoff)
        return result


@dataclass(frozen=True, slots=True)
class _Prediction:
    channels: tuple[Channel, ...]
    rate_hz: float
    start_ns: int
    rows: NDArray[np.float64]
    fit: RigidFit


def _place(grid_ns: NDArray[np.float64], motion: JointMotion, lag_s: float) -> NDArray[np.float64]:
    """Return where in the motion samples lie that are later by ``lag_s``."""
    place = (grid_ns - lag_s * NANOSECONDS_PER_SECOND - motion.origin_ns) / motion.period_ns
    return np.clip(place, 0.0, len(motion.position) - 1.0)


def _same(fresh: RigidFit, known: RigidFit) -> bool:
    """Tell whether a window says nothing new."""
    spread = np.hypot(fresh.lag_std_s, known.lag_std_s)
    late = np.abs(fresh.lag_s - known.lag_s) > MOTION.surprise * spread
    less_sure = bool(np.all(fresh.lag_std_s >= 0.8 * known.lag_std_s))
    alike = math.isclose(fresh.reach_hz, known.reach_hz, rel_tol=MOTION.same_reach)
    return less_sure and alike and not late.any() and bool(np.all(fresh.odd == known.odd))


def motion_of(
    samples: Samples,
    joints: JointSamples | None,
    robot: RobotMotion,
    highest_hz: float = math.inf,
) -> JointMotion | None:
    """Return the motion of the model's joints; None where joint states do not tell."""
    position = None if joints is None else in_model_order(joints, robot)
    if joints is None or position is None:
        return None
    motion = joint_motion(joints.stamp_ns, position, samples.start_ns, highest_hz)
    if motion is None:
        return None
    last_ns = motion.origin_ns + len(motion.position) * motion.period_ns
    least_ns = samples.duration_s * NANOSECONDS_PER_SECOND - MOTION.most_outside_s * 1e9
    if motion.origin_ns > MOTION.most_outside_s * 1e9 or last_ns < least_ns:
        return None
    return motion


def _fits(
    measured: NDArray[np.float64], rigid: NDArray[np.float64], sample_rate_hz: float
) -> bool:
    """Tell whether removal does not add slow motion to a channel."""
    width = max(1, round(sample_rate_hz / (2.0 * MOTION.slow_hz)))
    n = len(measured) // width
    if n < 3:
        return True
    slow = np.column_stack([measured, measured - rigid])[: n * width]
    means = slow.reshape(n, width, 2).mean(axis=1)
    before, after = means.var(axis=0)
    return bool(after <= MOTION.worse * before)
