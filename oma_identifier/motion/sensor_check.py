"""Whether gain, sign and axes of sensors are what the layout says, as far as the motion tells.

A sensor on a rigid arm has known readings: gravity at the pose, and the slow motion of its link.
They are compared with the measured ones: the constant part within the offsets sensors have, motion
within what a flexible arm adds and what no axis of the sensor explains.  A channel is suspected
where its reading is beyond that and a wrong gain or sign, or another axis of its sensor, explains
it; else the data do not tell.  Nothing is corrected.
"""

from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.channel import Channel
from modal_core.units import ACCELERATION
from oma_identifier.motion.rigid_fit import SlowMotion
from oma_identifier.motion.thresholds import MOTION

Real = NDArray[np.float64]

GAIN, POLARITY, AXES = 'gain_suspicion', 'polarity_suspicion', 'axes_suspicion'


def check_sensors(
    channels: Sequence[Channel], mean: Real, at_rest: Real, slow: SlowMotion | None
) -> dict[str, str]:
    """Return a flag per channel that reads what another gain, sign or axis would.

    Parameters
    ----------
    channels : sequence of Channel
        On links of the model.
    mean, at_rest : (n_channels,) array [m/s²], [rad/s]
        Measured over a window, and of an arm at rest in its pose.
    slow : SlowMotion or None
        None: nothing moves as a rigid arm would.
    """
    sensors: dict[tuple[str, str], list[int]] = {}
    for place, channel in enumerate(channels):
        sensors.setdefault((channel.sensor, channel.unit), []).append(place)
    found = {}
    for (_, unit), columns in sensors.items():
        evidence = [*_of_gravity(unit, mean[columns], at_rest[columns])]
        alike = [place for place, channel in enumerate(channels) if channel.unit == unit]
        evidence += [] if slow is None else [_of_motion(slow, columns, alike)]
        if evidence:
            flags = _flags([_Reading.of(evidence, place) for place in range(len(columns))])
            found.update({channels[columns[place]].name: flag for place, flag in flags.items()})
    return found


@dataclass(frozen=True, slots=True)
class _Evidence:
    """What the axes of a sensor read and should read.

    Parameters
    ----------
    measured, expected : (n_values, n_axes) array
    std : (n_axes,) array
        Of each value of an axis.
    """

    measured: Real
    expected: Real
    std: Real


def _of_gravity(unit: str, mean: Real, at_rest: Real) -> list[_Evidence]:
    """Return nothing of sensors that have no constant part."""
    if (
        unit != ACCELERATION
        or np.linalg.norm(mean) <= MOTION.explained_within * MOTION.offset_m_s2
    ):
        return []
    return [_Evidence(mean[None], at_rest[None], np.full(len(mean), MOTION.offset_m_s2))]


def _of_motion(slow: SlowMotion, columns: Sequence[int], alike: Sequence[int]) -> _Evidence:
    """Return the part of the motion that axes of the sensor can explain; the rest is noise.

    Flexibility adds to it by the largest motion of all channels that are alike.
    """
    expected, measured = slow.rigid[:, columns], slow.measured[:, columns]
    basis = np.linalg.svd(expected, full_matrices=False)[0]
    known = basis.T @ measured
    n_values, n_known = basis.shape
    rest = (measured**2).sum(axis=0) - (known**2).sum(axis=0)
    # The taper makes neighbouring lines alike: half of them count.
    noise = np.maximum(rest, 0.0) * 2.0 * n_known / max(n_values - 2 * n_known, 1)
    largest = (slow.rigid[:, alike] ** 2).sum(axis=0).max()
    return _Evidence(
        known, basis.T @ expected, np.sqrt(MOTION.flexible**2 * largest + noise) + 1e-300
    )


@dataclass(frozen=True, slots=True)
class _Reading:
    """What one axis reads, and what it would instead of every axis, over its deviation.

    Parameters
    ----------
    measured : (n_values,) array
    expected : (n_values, n_axes) array
    """

    measured: Real
    expected: Real

    @classmethod
    def of(cls, evidence: Sequence[_Evidence], axis: int) -> '_Reading':
        """Return the reading of an axis by all there is."""
        return cls(
            np.concatenate([part.measured[:, axis] / part.std[axis] for part in evidence]),
            np.concatenate([part.expected / part.std[axis] for part in evidence]),
        )

    def misfit(self, axis: int, gain: float = 1.0) -> float:
        """Return how far it is from the reading of an axis, in standard deviations."""
        reading = gain * self.expected[:, axis]
        apart = float(np.linalg.norm(self.measured - reading))
        return apart / math.hypot(1.0, MOTION.gain_tolerance * float(np.linalg.norm(reading)))

    def is_of(self, axis: int) -> bool:
        """Tell whether it may be the reading of an axis, either way round."""
        return min(self.misfit(axis), self.misfit(axis, -1.0)) <= MOTION.explained_within

    def has_wrong_gain(self, axis: int) -> bool:
        """Tell whether a gain explains it, and one that no healthy sensor has."""
        own = self.expected[:, axis]
        gain = float(own @ self.measured) / (float(own @ own) + 1e-300)
        wrong = abs(math.log(abs(gain) + 1e-300)) > math.log(MOTION.least_factor)
        return wrong and self.misfit(axis, gain) <= MOTION.explained_within


def _flags(readings: Sequence[_Reading]) -> dict[int, str]:
    """Return what explains the axes of a sensor that do not read what they should."""
    odd = [
        axis for axis, reading in enumerate(readings) if reading.misfit(axis) > MOTION.wrong_from
    ]
    moved = {
        (axis, other)
        for axis in odd
        for other in range(len(readings))
        if other != axis and readings[axis].is_of(other)
    }
    found = {}
    for axis in odd:
        reads_another = any(first == axis for first, _ in moved)
        is_read_by_another = any(second == axis for _, second in moved)
        if readings[axis].misfit(axis, -1.0) <= MOTION.explained_within:
            found[axis] = POLARITY
        # A gain may be any and explains more by chance than an exchange that fits both ways.
        elif reads_another and is_read_by_another:
            found[axis] = AXES
        elif readings[axis].has_wrong_gain(axis):
            found[axis] = GAIN
        elif reads_another:
            found[axis] = AXES
    return found
