"""Sensors wired, mounted or timed wrongly: their readings before noise and conversion."""

from collections.abc import Sequence
import math

import numpy as np
from numpy.typing import NDArray
from scipy.signal import cont2discrete, lfilter, lfilter_zi

from abb_emulator.mechanics import ArmEffect, AXES, check_place
from abb_emulator.sensing.delay_line import DelayLine
from modal_core.channel import Channel

Array = NDArray[np.float64]


class SensorErrors:
    """Gain, polarity, swapped axes, rotation, delay and soft mounts, in the order given.

    Parameters
    ----------
    effects : sequence of ArmEffect
        Those of sensors; others do nothing.
    channels : sequence of Channel
        Columns of the readings.
    sample_rate_hz : float [Hz]
        Of the readings.
    rest : (n_channels,) array
        Readings before the beginning.
    """

    def __init__(
        self,
        effects: Sequence[ArmEffect],
        channels: Sequence[Channel],
        sample_rate_hz: float,
        rest: Array,
    ) -> None:
        names = [channel.name for channel in channels]
        sensors = tuple(dict.fromkeys(name.split('.')[0] for name in names))
        self._mixing = np.eye(len(names))
        mounts: list[tuple[int, ArmEffect]] = []
        delay_s = np.zeros(len(names))
        for effect in effects:
            if not effect.type.startswith('sensor_') or effect.type == 'sensor_mass':
                continue
            check_place(effect, sensors)
            rows = [i for i, name in enumerate(names) if name.split('.')[0] == effect.place]
            chosen = [
                row
                for row in rows
                if effect.values.get('axis', '') in ('', names[row].rsplit('.', 1)[-1][-1])
            ]
            if effect.type == 'sensor_delay':
                delay_s[rows] += effect.number('delay')
            elif effect.type == 'sensor_mount_resonance':
                mounts += [(row, effect) for row in chosen]
            else:
                self._mix(effect, rows, chosen)
        mixed = self._mixing @ rest
        self._mounts = [_Mount(row, item, sample_rate_hz, mixed[row]) for row, item in mounts]
        self.lead_steps, self._lines = _delays(delay_s * sample_rate_hz, mixed)
        self._idle = not self._lines and not mounts and np.array_equal(
            self._mixing, np.eye(len(names))
        )  # fmt: skip

    def apply(self, readings: Array) -> Array:
        """Return what the sensors deliver, (n_samples, n_channels), ``lead_steps`` late."""
        if self._idle:
            return readings
        delivered = readings @ self._mixing.T
        for mount in self._mounts:
            mount.apply(delivered)
        for columns, line in self._lines:
            delivered[:, columns] = line.push(delivered[:, columns])
        return delivered

    def _mix(self, effect: ArmEffect, rows: list[int], chosen: list[int]) -> None:
        change = np.eye(len(self._mixing))
        if effect.type == 'sensor_gain':
            change[chosen, chosen] = effect.number('gain')
        elif effect.type == 'sensor_polarity':
            change[chosen, chosen] = -1.0
        else:
            turn = (
                _swap(effect.text('axes'))
                if effect.type == 'sensor_axis_swap'
                else _rotation(np.array(effect.vector('rotation')))
            )
            for first in range(0, len(rows) - 2, 3):
                three = np.array(rows[first : first + 3])
                change[np.ix_(three, three)] = turn
        self._mixing = change @ self._mixing


class _Mount:
    """(1 + 2iζr)/(1 - r² + 2iζr), r = f/f_m: motion of a mass on a spring, base moved."""

    def __init__(self, row: int, effect: ArmEffect, sample_rate_hz: float, rest: float) -> None:
        omega, zeta = 2.0 * math.pi * effect.number('frequency'), effect.number('damping_ratio')
        system = ([2.0 * zeta * omega, omega**2], [1.0, 2.0 * zeta * omega, omega**2])
        numerator, self._below, _ = cont2discrete(system, 1.0 / sample_rate_hz, 'foh')
        self._above, self._row = np.ravel(numerator), row
        self._state = lfilter_zi(self._above, self._below) * rest

    def apply(self, delivered: Array) -> None:
        """Filter its column in place."""
        delivered[:, self._row], self._state = lfilter(
            self._above, self._below, delivered[:, self._row], zi=self._state
        )


def _delays(steps: Array, rest: Array) -> tuple[int, list[tuple[NDArray[np.intp], DelayLine]]]:
    """Return by how many whole steps all come late, and the lines with their columns."""
    if not steps.any():
        return 0, []
    # A line is late by a step at least; a sensor that is early makes all others later.
    lead = math.ceil(1.0 - float(steps.min()))
    lines = []
    for value in np.unique(steps):
        columns = np.flatnonzero(steps == value)
        lines.append((columns, DelayLine(lead + float(value), rest[columns])))
    return lead, lines


def _swap(axes: str) -> Array:
    first, second = (AXES.index(axis) for axis in axes)
    order = [0, 1, 2]
    order[first], order[second] = second, first
    return np.eye(3)[order]


def _rotation(vector: Array) -> Array:
    """Return the rotation matrix of a rotation vector (Rodrigues)."""
    angle = float(np.linalg.norm(vector))
    if angle == 0.0:
        return np.eye(3)
    x, y, z = vector / angle
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + math.sin(angle) * skew + (1.0 - math.cos(angle)) * skew @ skew)
