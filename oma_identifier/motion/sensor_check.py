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

Real = NDArray[np.float64]

OFFSET_M_S2 = 0.5
"""Standard deviation of the constant error of a sensor: a third of the 150 mg that the data sheets
of plain MEMS accelerometers allow."""
FLEXIBLE = 0.04
"""What flexibility adds to slow motion, as a share of the largest on the arm: a third of the 1/8
that a mode adds at a third of its frequency."""
TOLERANCE = 0.1
"""Standard deviation of a healthy gain: calibration, place and mounting together."""
BEYOND, EXPLAINED = 4.0, 3.0
"""Standard deviations from where on a reading is wrong (as 3 in 10,000 are of two values that
tell), and within which a fault explains it."""
LEAST_FACTOR = math.sqrt(2.0)
"""A wrong gain is nearer to twice or half what it should be."""
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
        name = channel.name.rpartition('.')[0] or channel.name
        sensors.setdefault((name, channel.unit), []).append(place)
    found = {}
    for (_, unit), columns in sensors.items():
        evidence = [*_of_gravity(unit, mean[columns], at_rest[columns])]
        alike = [place for place, channel in enumerate(channels) if channel.unit == unit]
        evidence += [] if slow is None else [_of_motion(slow, columns, alike)]
        for place, column in enumerate(columns):
            flag = _flag([part.of(place) for part in evidence], place)
            if flag:
                found[channels[column].name] = flag
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

    def of(self, axis: int) -> tuple[Real, Real]:
        """Return the readings of an axis, and those of every axis, over its deviation."""
        return self.measured[:, axis] / self.std[axis], self.expected / self.std[axis]


def _of_gravity(unit: str, mean: Real, at_rest: Real) -> list[_Evidence]:
    """Return nothing of sensors that have no constant part."""
    if unit != ACCELERATION or np.linalg.norm(mean) <= EXPLAINED * OFFSET_M_S2:
        return []
    return [_Evidence(mean[None], at_rest[None], np.full(len(mean), OFFSET_M_S2))]


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
    return _Evidence(known, basis.T @ expected, np.sqrt(FLEXIBLE**2 * largest + noise) + 1e-300)


def _flag(readings: Sequence[tuple[Real, Real]], own: int) -> str:
    """Return what explains the readings of a channel that should be those of its own axis."""
    if not readings:
        return ''
    measured = np.concatenate([part for part, _ in readings])
    expected = np.concatenate([part for _, part in readings])

    def misfit(axis: int, gain: float) -> float:
        reading = gain * expected[:, axis]
        apart = float(np.linalg.norm(measured - reading))
        return apart / math.hypot(1.0, TOLERANCE * float(np.linalg.norm(reading)))

    if misfit(own, 1.0) <= BEYOND:
        return ''
    faults = {(own, -1.0): POLARITY}
    power = float(expected[:, own] @ expected[:, own])
    gain = float(expected[:, own] @ measured) / (power + 1e-300)
    if abs(math.log(abs(gain) + 1e-300)) > math.log(LEAST_FACTOR):
        faults[own, gain] = GAIN
    others = (axis for axis in range(expected.shape[1]) if axis != own)
    faults |= {(axis, sign): AXES for axis in others for sign in (1.0, -1.0)}
    best = min(faults, key=lambda fault: misfit(*fault))
    return faults[best] if misfit(*best) <= EXPLAINED else ''
