"""What sensors do to readings, (n, 3 a sensor) at one rate: by interpolation and filters in time.

The suite's own effects act on spectra; these on series.
"""

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import bilinear, fftconvolve, lfilter
from scipy.spatial.transform import Rotation

G = 9.80665
# Steps of a mount in one of the recording.
FINER = 16


def spoil(case, readings, rate_hz, columns, rng):
    """Return the readings as a faulty sensor or recorder shows them.

    ``columns`` are the sensor's own; faults of the recorder take all.
    """
    fault = FAULTS.get(case['type'])
    if fault is None:
        return readings
    readings = readings.copy()
    return fault(case, readings, rate_hz, columns, rng)


def _gain(case, y, rate_hz, own, rng):
    y[:, own] *= case['gain']
    return y


def _unit(case, y, rate_hz, own, rng):
    y[:, own] /= G
    return y


def _polarity(case, y, rate_hz, own, rng):
    y[:, own[case['axis']]] *= -1.0
    return y


def _axis_swap(case, y, rate_hz, own, rng):
    one, two = (own[number] for number in case['axes'])
    y[:, [one, two]] = y[:, [two, one]]
    return y


def _rotation(case, y, rate_hz, own, rng):
    y[:, own] = Rotation.from_rotvec(case['vector']).apply(y[:, own])
    return y


def _delay(case, y, rate_hz, own, rng):
    times = np.arange(len(y)) / rate_hz
    wanted = np.clip(times - case['delay'], 0.0, times[-1])
    y[:, own] = CubicSpline(times, y[:, own], axis=0)(wanted)
    return y


def _mount(case, y, rate_hz, own, rng):
    """A mass on a spring: absolute motion of the sensor by that of its base, in time.

    In steps so fine that the bilinear transform moves no frequency: at the recorded rate a
    resonance of 68 Hz looks like one of 73 Hz from far below.
    """
    omega, fine_hz = 2.0 * np.pi * case['f'], FINER * rate_hz
    b, a = bilinear(
        [2.0 * case['zeta'] * omega, omega**2],
        [1.0, 2.0 * case['zeta'] * omega, omega**2],
        fine_hz,
    )
    times = np.arange(FINER * (len(y) - 1) + 1) / fine_hz
    moving = CubicSpline(times[::FINER], y[:, own] - y[0, own], axis=0)(times)
    y[:, own] = y[0, own] + lfilter(b, a, moving, axis=0)[::FINER]
    return y


def _clipping(case, y, rate_hz, own, rng):
    middle = y.mean(axis=0)
    limit = case['at'] * (y - middle).std()
    return middle + np.clip(y - middle, -limit, limit)


def _clock_drift(case, y, rate_hz, own, rng):
    times = np.arange(len(y)) / rate_hz
    return CubicSpline(times, y, axis=0)(np.clip(times * (1.0 + case['rate']), 0.0, times[-1]))


def _loose(case, y, rate_hz, own, rng):
    """It knocks whenever it is shaken hard, and rings."""
    moving = y[:, own] - y[:, own].mean(axis=0)
    size = moving.std()
    hard = np.abs(moving).max(axis=1) > case['at'] * size
    starts = (hard[1:] & ~hard[:-1])[:, None] * rng.standard_normal((len(y) - 1, 3))
    times = np.arange(round(0.08 * rate_hz)) / rate_hz
    ring = (np.exp(-times / 0.012) * np.sin(2.0 * np.pi * case['f'] * times))[:, None]
    y[1:, own] += case['size'] * size * fftconvolve(starts, ring, axes=0)[: len(y) - 1]
    return y


FAULTS = {
    'sensor_gain': _gain,
    'sensor_unit': _unit,
    'sensor_polarity': _polarity,
    'sensor_axis_swap': _axis_swap,
    'sensor_rotation': _rotation,
    'sensor_delay': _delay,
    'sensor_mount_resonance': _mount,
    'clipping': _clipping,
    'clock_drift': _clock_drift,
    'loose_sensor': _loose,
}
