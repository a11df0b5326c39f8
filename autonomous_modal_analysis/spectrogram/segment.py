"""One short stretch of samples, and its spectrum."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
SEGMENT_S, FEWEST_SAMPLES = 2.0, 64
"""Length of a segment [s], and of one at a low rate: lines half a hertz apart, and a speed that a
robot's stroke still resolves.  Chosen, not measured."""
MOST_LINES = 2048
"""Kept of a spectrum; neighbours are pooled beyond."""


class Segments:
    """Spectra of stretches of one length.

    Parameters
    ----------
    sample_rate_hz : float [Hz]
        Of all.
    """

    def __init__(self, sample_rate_hz: float) -> None:
        self.length = max(round(SEGMENT_S * sample_rate_hz), FEWEST_SAMPLES)
        self.duration_s = self.length / sample_rate_hz
        self._window = np.hanning(self.length + 1)[:-1]
        self._scale = 2.0 / (sample_rate_hz * np.sum(self._window**2))
        self._pooled = -(-(self.length // 2) // MOST_LINES)
        self.n_lines = self.length // 2 // self._pooled

    @property
    def frequency_hz(self) -> Array:
        """Frequencies of the lines, (n_lines,) [Hz]; that of the mean is left out."""
        first = 1.0 + 0.5 * (self._pooled - 1)
        lines = first + self._pooled * np.arange(self.n_lines, dtype=float)
        return np.asarray(lines / self.duration_s, dtype=np.float64)

    def psd(self, part: Array) -> Array:
        """Return the power spectral density of a segment, the mean over its channels.

        Parameters
        ----------
        part : (length, n_channels) array [SI unit]
            Samples.

        Returns
        -------
        (n_lines,) array [(SI unit)²/Hz]
            One-sided, by a Hann window.
        """
        lines = np.fft.rfft(self._window[:, None] * (part - part.mean(axis=0)), axis=0)
        power = self._scale * np.mean(np.abs(lines[1:]) ** 2, axis=1)
        used = power[: self.n_lines * self._pooled]
        return np.asarray(used.reshape(self.n_lines, self._pooled).mean(axis=1))
