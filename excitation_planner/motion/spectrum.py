"""What a planned motion contains: its acceleration spectrum, its band, how flat and how white."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import welch

Array = NDArray[np.float64]
# Below this part of the largest density a frequency does not count as excited.
EXCITED_DB = -10.0
# Kolmogorov's 5 % point of the largest distance from a straight line, times sqrt(n).
KOLMOGOROV_5_PERCENT = 1.358


@dataclass(frozen=True, slots=True)
class PredictedSpectrum:
    """Predicted power spectral density of the accelerations of the controller axes.

    Parameters
    ----------
    frequency_hz : (n_frequencies,) array [Hz]
        From 0 to half the sample rate.
    density : (n_frequencies, n_joints) array [(rad/s²)²/Hz]
        One-sided.
    """

    frequency_hz: Array
    density: Array

    @property
    def mean_density(self) -> Array:
        """Mean over the moving joints, each scaled to its own mean square, (n_frequencies,)."""
        power = np.sum(self.density, axis=0)
        moving = power > 0.0
        if not np.any(moving):
            return np.zeros(len(self.frequency_hz))
        return np.asarray(np.mean(self.density[:, moving] / power[moving], axis=1))

    def rms(self, band_hz: tuple[float, float]) -> Array:
        """Return the acceleration of every axis in a band, (n_joints,) [rad/s²]."""
        step_hz = self.frequency_hz[1] - self.frequency_hz[0]
        return np.asarray(np.sqrt(np.sum(self.density[self._inside(band_hz)], axis=0) * step_hz))

    def at(self, frequency_hz: Array) -> Array:
        """Interpolate the density, (n_wanted, n_joints) [(rad/s²)²/Hz]."""
        columns = [np.interp(frequency_hz, self.frequency_hz, d) for d in self.density.T]
        return np.column_stack(columns)

    def excited_band_hz(
        self, wanted_hz: tuple[float, float] = (0.0, np.inf)
    ) -> tuple[float, float]:
        """Return the band around the strongest wanted frequency that stays within 10 dB of it.

        Slow sweeps below the wanted frequencies may be stronger than all of them.
        """
        density = self.mean_density
        wanted = np.where(self._inside(wanted_hz), density, 0.0)
        if not np.any(wanted > 0.0):
            return 0.0, 0.0
        excited = density >= np.max(wanted) * 10.0 ** (EXCITED_DB / 10.0)
        peak = int(np.argmax(wanted))
        low = peak - int(np.argmin(np.append(excited[peak::-1], False))) + 1
        high = peak + int(np.argmin(np.append(excited[peak:], False))) - 1
        return float(self.frequency_hz[low]), float(self.frequency_hz[high])

    def flatness_db(self, band_hz: tuple[float, float]) -> float:
        """Return largest over smallest mean density in a band [dB]; 0 is perfectly flat."""
        density = self.mean_density[self._inside(band_hz)]
        if len(density) == 0 or np.min(density) <= 0.0:
            return float('inf')
        return float(10.0 * np.log10(np.max(density) / np.min(density)))

    def _inside(self, band_hz: tuple[float, float]) -> NDArray[np.bool_]:
        return (self.frequency_hz >= band_hz[0]) & (self.frequency_hz <= band_hz[1])


@dataclass(frozen=True, slots=True)
class Whiteness:
    """Bartlett's cumulative periodogram test of one joint in a band.

    Parameters
    ----------
    statistic : float
        Largest distance of the normalised cumulative periodogram from a straight line.
    critical : float
        What white noise of this length exceeds in 5 % of records.
    """

    statistic: float
    critical: float

    @property
    def white(self) -> bool:
        """True when the record cannot be told from white noise in the band."""
        return self.statistic <= self.critical


def predicted_spectrum(
    acceleration: Array, sample_period_s: float, resolution_hz: float = 0.5
) -> PredictedSpectrum:
    """Estimate the spectrum of planned accelerations (Welch, Hann, half overlap).

    Parameters
    ----------
    acceleration : (n_samples, n_joints) array [rad/s²]
        Of the controller axes, which are what the plan drives independently.
    sample_period_s : float [s]
        Its grid.
    resolution_hz : float [Hz]
        Spacing of the frequencies, coarser when the motion is shorter than its inverse.
    """
    rate_hz = 1.0 / sample_period_s
    segment = min(len(acceleration), round(rate_hz / resolution_hz))
    frequency_hz, density = welch(acceleration, fs=rate_hz, nperseg=segment, axis=0, detrend=False)
    return PredictedSpectrum(np.asarray(frequency_hz), np.asarray(density))


def flat_spectrum(acceleration_rms: Array, band_hz: tuple[float, float]) -> PredictedSpectrum:
    """Return the spectrum of white acceleration in a band.

    Parameters
    ----------
    acceleration_rms : (n_joints,) array [rad/s²]
        Of the controller axes.
    band_hz : (2,) tuple [Hz]
        Nothing outside.
    """
    low, high = band_hz
    edges = np.array([0.0, low * (1 - 1e-9), low, high, high * (1 + 1e-9), 2.0 * high])
    inside = np.array([0.0, 0.0, 1.0, 1.0, 0.0, 0.0])
    return PredictedSpectrum(edges, np.outer(inside, acceleration_rms**2 / (high - low)))


def whiteness(signal: Array, sample_period_s: float, band_hz: tuple[float, float]) -> Whiteness:
    """Test whether a signal is white within a band.

    Parameters
    ----------
    signal : (n_samples,) array
        For example the planned acceleration of one joint.
    sample_period_s : float [s]
        Its grid.
    band_hz : (2,) tuple [Hz]
        Where it should be white.

    References
    ----------
    Bartlett (1955), An Introduction to Stochastic Processes; Brockwell and Davis (1991), 10.2.
    """
    frequency_hz = np.fft.rfftfreq(len(signal), sample_period_s)
    power = np.abs(np.fft.rfft(signal)) ** 2
    inside = (frequency_hz >= band_hz[0]) & (frequency_hz <= band_hz[1])
    cumulative = np.cumsum(power[inside])
    n_lines = len(cumulative)
    straight = np.arange(1, n_lines + 1) / n_lines
    statistic = float(np.max(np.abs(cumulative / cumulative[-1] - straight)))
    return Whiteness(statistic, KOLMOGOROV_5_PERCENT / np.sqrt(n_lines))
