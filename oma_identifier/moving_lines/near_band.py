"""What is near a frequency, at a rate as low as its band: the record is transformed once."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.fft import ifft, next_fast_len, rfft

from oma_identifier.moving_lines.course import baseband, cosine_coefficients

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
SEEN_AROUND = 24.0
"""Reaches within which rows are seen before what is beyond one is left out: in the transform the
ends of a record meet, and so are told apart but for a 24th of the time of a change."""


@dataclass(frozen=True, slots=True)
class NearBand:
    """The transform of rows, from which narrow bands are cut.

    Parameters
    ----------
    rows : (n_rows, n_channels) array
        Real.
    level : (n_lines, n_channels) complex array
        Their transform, from 0 Hz.
    rate_hz : float [Hz]
        Of the rows.
    """

    rows: Real
    level: Complex
    rate_hz: float

    @classmethod
    def of(cls, rows: Real, rate_hz: float) -> 'NearBand':
        """Transform rows but for at most the last hundredth, so many that it takes no time."""
        length = next_fast_len(len(rows) - len(rows) // 100, real=True)
        return cls(rows[:length], np.asarray(rfft(rows[:length], axis=0)), rate_hz)

    @property
    def n_rows(self) -> int:
        """Return how many rows were transformed."""
        return len(self.rows)

    def phasor(self, hz: float, reach_hz: float) -> tuple[Complex, Real]:
        """Return the strongest sum of channels near a frequency, turned back by it.

        Parameters
        ----------
        hz, reach_hz : float [Hz]
            Middle and half-width of the band.

        Returns
        -------
        phasor : (n_slow,) complex array
        time : (n_slow,) array [s]
        """
        rows, turn, rate_hz = self._turned(hz, reach_hz)
        slow, time = baseband(rows, turn, rate_hz, reach_hz)
        _, vectors = np.linalg.eigh(slow.T @ slow.conj())
        return np.asarray(slow @ vectors[:, -1].conj()), time

    def coefficients(self, hz: float, n_kept: int) -> Complex:
        """Return the first cosine coefficients of rows turned back, (n_kept, n_channels).

        Parameters
        ----------
        hz : float [Hz]
        n_kept : int
            Of half a period per record each.
        """
        rows, turn, _ = self._turned(hz, 0.5 * n_kept * self.rate_hz / self.n_rows)
        level = cosine_coefficients(np.exp(-1j * turn)[:, None] * rows)[:n_kept]
        return np.asarray(level * np.sqrt(self.n_rows / len(rows)))

    def _turned(self, hz: float, reach_hz: float) -> tuple[Complex, Real, float]:
        """Return what is near a frequency, its phase against that [rad], and the rate [Hz]."""
        duration_s = self.n_rows / self.rate_hz
        middle = round(hz * duration_s)
        n_band = next_fast_len(2 * max(8, round(SEEN_AROUND * reach_hz * duration_s)))
        places = middle - n_band // 2 + np.arange(n_band)
        inside = (places > 0) & (places < len(self.level))
        band = np.zeros((n_band, self.level.shape[1]), dtype=complex)
        band[inside] = self.level[places[inside]]
        rows = ifft(np.fft.ifftshift(band, axes=0), axis=0) * (n_band / self.n_rows)
        turn = np.asarray(2.0 * np.pi * (hz * duration_s - middle) * np.arange(n_band) / n_band)
        return rows, turn, n_band / duration_s
