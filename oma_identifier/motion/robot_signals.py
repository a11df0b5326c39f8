"""What the robot's own motion puts into the responses of a window, taken out or recognised."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from modal_core.mode import Mode
from modal_core.quality import ChannelQuality, DataQuality
from modal_core.samples import Samples
from modal_core.window import Window
from oma_identifier.motion.drive_orders import remove_drive_orders
from oma_identifier.motion.joint_motion import joint_motion, JointMotion
from oma_identifier.motion.known_inputs import at_samples
from oma_identifier.motion.motion_peak import is_motion
from oma_identifier.motion.rigid_motion import RigidMotionRemoval
from oma_identifier.motion.robot_motion import RobotMotion
from oma_identifier.motion.sensor_lag import Lag
from oma_identifier.motion.thresholds import MOTION

PeakTest = Callable[[float, float, NDArray[np.complex128]], bool]
"""Place [Hz], half-power half-width [Hz] and direction of a peak: is it no mode?  Functions of a
module with what they know bound to them (``partial``): another process can be given them."""


def never(frequency_hz: float, width_hz: float, shape: NDArray[np.complex128]) -> bool:
    """Explain no peak."""
    return False


@dataclass(frozen=True, slots=True)
class Cleaned:
    """A window without the robot's own signals, as far as they are known.

    Parameters
    ----------
    samples : Samples
        What is left.
    lines : tuple of Mode
        Orders of the drives that were taken out, marked harmonic.
    explains : callable
        Tells whether a peak is left over from motion, and no mode.
    flags : tuple of str
        Of the window: ``rigid_motion_removed``, ``drive_lines``, ``gross_motion``.
    channel_flags : dict of str to str
        By channel.
    lags : dict of str to Lag
        Delays against the joint states, or else the other sensors, by channel.
    motion : JointMotion or None
        Of the joints, on the clock of the responses; None where a model cannot find it in them.
    left_out : tuple of str
        Channels that ``samples`` does without.
    since_ns : dict of str to int [ns]
        Since when changed channels are what they are.
    interrupted_ns : dict of str to tuple of (int, int) [ns]
        From when to when channels were not heard.
    """

    samples: Samples
    lines: tuple[Mode, ...]
    explains: PeakTest
    flags: tuple[str, ...]
    channel_flags: dict[str, str]
    lags: dict[str, Lag] = field(default_factory=dict)
    motion: JointMotion | None = None
    left_out: tuple[str, ...] = ()
    since_ns: dict[str, int] = field(default_factory=dict)
    interrupted_ns: dict[str, tuple[tuple[int, int], ...]] = field(default_factory=dict)


def with_flags(quality: DataQuality, cleaned: Cleaned) -> DataQuality:
    """Return the health of a window with what was found in cleaning it."""
    channels = tuple(_with_finding(channel, cleaned) for channel in quality.channels)
    flags = tuple(dict.fromkeys((*quality.flags, *cleaned.flags)))
    return replace(quality, flags=flags, channels=channels)


def _with_finding(channel: ChannelQuality, cleaned: Cleaned) -> ChannelQuality:
    lag = cleaned.lags.get(channel.name)
    if lag is not None:
        channel = replace(channel, lag_s=lag.seconds, lag_std_s=lag.std_s)
    if channel.name in cleaned.channel_flags:
        channel = replace(channel, flags=(*channel.flags, cleaned.channel_flags[channel.name]))
    if channel.name in cleaned.since_ns:
        channel = replace(channel, since_ns=cleaned.since_ns[channel.name])
    if channel.name in cleaned.interrupted_ns:
        channel = replace(channel, interrupted_ns=cleaned.interrupted_ns[channel.name])
    if channel.name in cleaned.left_out:
        channel = replace(channel, excluded=True)
    return channel


class RobotSignals:
    """Cleans window after window.

    Parameters
    ----------
    robot : RobotMotion or None
        Model of the robot; None: motion is recognised by its size only, and filtered.
    """

    def __init__(self, robot: RobotMotion | None = None) -> None:
        self._robot = robot
        self._removal = None if robot is None else RigidMotionRemoval(robot)

    def clean(self, window: Window) -> Cleaned:
        """Return the window's samples without what the joint states explain."""
        if self._robot is None or self._removal is None:
            return _unmodelled(window)
        removed = self._removal.remove(window.samples, window.joints)
        if removed.motion is None:
            return _unmodelled(window)
        angle = self._robot.drive_angle(removed.motion.position)
        found = remove_drive_orders(
            removed.samples, at_samples(angle, removed.motion, window.samples)
        )
        flags = [*_flags(removed.motion)]
        flags += ['rigid_motion_removed'] if removed.fit is not None else []
        flags += ['drive_lines'] if found.orders else []
        test = _peak_test(window.samples, found.samples, removed.motion)
        return Cleaned(
            samples=found.samples,
            lines=found.lines,
            explains=test,
            flags=tuple(flags),
            channel_flags=removed.flags,
            lags=removed.lags,
            motion=None if removed.fit is None else removed.motion,
        )


def _unmodelled(window: Window) -> Cleaned:
    samples, joints = window.samples, window.joints
    motion = None
    if joints is not None and np.ptp(joints.position, axis=0).max() > 0.0:
        motion = joint_motion(joints.stamp_ns, joints.position, samples.start_ns)
    if motion is None:
        return Cleaned(samples, (), never, (), {})
    test = _peak_test(samples, samples, motion)
    return Cleaned(samples, (), test, _flags(motion), {}, motion=motion)


def _flags(motion: JointMotion) -> tuple[str, ...]:
    return ('gross_motion',) if _travels(motion) else ()


def _travels(motion: JointMotion) -> bool:
    return bool(np.ptp(motion.position, axis=0).max() > MOTION.gross_rad)


def _peak_test(measured: Samples, left: Samples, motion: JointMotion) -> PeakTest:
    # An arm that shakes itself in place moves at its modes because its joints do.
    return partial(is_motion, measured, left, motion) if _travels(motion) else never
