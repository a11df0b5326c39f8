"""Band-limited resampling and differentiation of uniformly sampled series."""

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from model_gap.campaign.thresholds import CAMPAIGN

Array = NDArray[np.float64]


def at_times(
    values: Array, rate_hz: float, times_s: Array, order: int = 0, highest_hz: float = np.inf
) -> Array:
    """Return a series or one of its derivatives at given times.

    The ends are continued by point reflection, so that value and slope stay continuous; then the
    series is differentiated and interpolated by Fourier transform.

    Parameters
    ----------
    values : (n_samples, n_columns) array
        Sampled from time 0 on.
    rate_hz : float [Hz]
        Of the samples.
    times_s : (n_times,) array [s]
        Within the samples.
    order : int
        Of the derivative.
    highest_hz : float [Hz]
        What lies above is left out.
    """
    count = len(values)
    pad = min(count - 1, round(CAMPAIGN.padding_s * rate_hz))
    before = 2.0 * values[0] - values[pad:0:-1]
    after = 2.0 * values[-1] - values[-2 : -pad - 2 : -1]
    long = np.concatenate([before, values, after])
    ramp = np.linspace(0.0, 1.0, len(long))[:, None]
    line = long[0] + (long[-1] - long[0]) * ramp
    spectrum = np.fft.rfft(long - line, axis=0)
    frequency = np.fft.rfftfreq(len(long), 1.0 / rate_hz)
    factor = (2j * np.pi * frequency) ** order
    factor[frequency > highest_hz] = 0.0
    fine = np.zeros((len(long) * CAMPAIGN.finer // 2 + 1, values.shape[1]), dtype=complex)
    fine[: len(spectrum)] = spectrum * factor[:, None]
    dense = np.fft.irfft(fine, len(long) * CAMPAIGN.finer, axis=0) * CAMPAIGN.finer
    dense_times = np.arange(len(dense)) / (rate_hz * CAMPAIGN.finer) - pad / rate_hz
    found = CubicSpline(dense_times, dense, axis=0)(times_s)
    slope = (long[-1] - long[0]) / ((len(long) - 1) / rate_hz)
    if order == 0:
        found = found + long[0] + slope * (times_s[:, None] + pad / rate_hz)
    elif order == 1:
        found = found + slope
    return np.asarray(found)


def thinned(values: Array, rate_hz: float, every: int) -> Array:
    """Return every so-manieth sample of a series whose upper band was taken away before.

    Parameters
    ----------
    values : (n_samples, n_columns) array
        Uniform; continued at both ends by point reflection.
    rate_hz : float [Hz]
        Of the samples.
    every : int
        1 returns the series itself.
    """
    if every == 1:
        return values
    count = len(values) // every * every
    values = values[:count]
    pad = min(count - 1, round(CAMPAIGN.padding_s * rate_hz)) // every * every
    before = 2.0 * values[0] - values[pad:0:-1]
    after = 2.0 * values[-1] - values[-2 : -pad - 2 : -1]
    long = np.concatenate([before, values, after])
    spectrum = np.fft.rfft(long, axis=0)[: len(long) // every // 2 + 1]
    short = np.fft.irfft(spectrum, len(long) // every, axis=0) / every
    return np.asarray(short[pad // every : (pad + count) // every])
