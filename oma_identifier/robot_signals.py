"""What the robot's own motion puts into the responses of a window, taken out or recognised."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_core.mode import Mode
from modal_core.quality import DataQuality
from modal_core.samples import Samples
from modal_core.window import Window
from oma_identifier.drive_orders import remove_drive_orders
from oma_identifier.gross_motion import explained_by_motion, is_gross
from oma_identifier.joint_motion import joint_motion, JointMotion
from oma_identifier.resample import interpolate
from oma_identifier.rigid_motion import RigidMotionRemoval
from oma_identifier.robot_motion import RobotMotion

PeakTest = Callable[[float, float, NDArray[np.complex128]], bool]
"""Place [Hz], half-power half-width [Hz] and direction of a peak: is it no mode?"""


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
    """

    samples: Samples
    lines: tuple[Mode, ...]
    explains: PeakTest
    flags: tuple[str, ...]
    channel_flags: dict[str, str]


def with_flags(quality: DataQuality, cleaned: Cleaned) -> DataQuality:
    """Return the health of a window with what was found in cleaning it."""
    if not cleaned.flags and not cleaned.channel_flags:
        return quality
    channels = tuple(
        replace(channel, flags=(*channel.flags, cleaned.channel_flags[channel.name]))
        if channel.name in cleaned.channel_flags
        else channel
        for channel in quality.channels
    )
    flags = tuple(dict.fromkeys((*quality.flags, *cleaned.flags)))
    return replace(quality, flags=flags, channels=channels)


class RobotSignals:
    """Cleans window after window.

    Parameters
    ----------
    robot : RobotMotion or None
        Model of the robot; None: motion is recognised by its size only, and filtered.
    """

    def __init__(self, robot: RobotMotion | None = None) -> None:
        self._robot = robot
        self._remove = None if robot is None else RigidMotionRemoval(robot)

    def __call__(self, window: Window) -> Cleaned:
        """Return the window's samples without what the joint states explain."""
        if self._robot is not None and self._remove is not None:
            removed = self._remove(window.samples, window.joints)
            if removed.motion is not None:
                flags = ['rigid_motion_removed'] if removed.jacobian is not None else []
                angle = self._robot.drive_angle(removed.motion.position)
                found = remove_drive_orders(
                    removed.samples, _at_samples(angle, removed.motion, window.samples)
                )
                flags += ['drive_lines'] if found.orders else []
                return Cleaned(
                    found.samples, found.lines, removed.explains, tuple(flags), removed.flags
                )
        return _unmodelled(window)


def _unmodelled(window: Window) -> Cleaned:
    samples, joints = window.samples, window.joints
    motion = None
    if joints is not None and np.ptp(joints.position, axis=0).max() > 0.0:
        motion = joint_motion(joints.stamp_ns, joints.position, samples.start_ns)
    if motion is None or not is_gross(motion):
        return Cleaned(samples, (), never, (), {})
    known = motion

    def explains(frequency_hz: float, width_hz: float, shape: NDArray[np.complex128]) -> bool:
        return explained_by_motion(samples, known, frequency_hz, width_hz, shape)

    return Cleaned(samples, (), explains, ('gross_motion',), {})


def _at_samples(
    values: NDArray[np.float64], motion: JointMotion, samples: Samples
) -> NDArray[np.float64]:
    """Return values at the joints' instants at those of the samples."""
    step_ns = NANOSECONDS_PER_SECOND / samples.sample_rate_hz
    place = (np.arange(len(samples.acceleration)) * step_ns - motion.origin_ns) / motion.period_ns
    return interpolate(values, np.clip(place, 0.0, len(values) - 1.0))
