"""What is near a frequency, at a rate as low as its band: the record is transformed once."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.fft import ifft, next_fast_len, rfft

from oma_identifier.moving_lines.course import baseband

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
    level : (n_lines, n_channels) complex array
        Of real rows, from 0 Hz.
    n_rows : int
        Of these.
    rate_hz : float [Hz]
        Theirs.
    """

    level: Complex
    n_rows: int
    rate_hz: float

    @classmethod
    def of(cls, rows: Real, rate_hz: float) -> 'NearBand':
        """Transform rows but for at most the last hundredth, so many that it takes no time."""
        length = next_fast_len(len(rows) - len(rows) // 100, real=True)
        rows = rows[:length]
        return cls(np.asarray(rfft(rows, axis=0)), len(rows), rate_hz)

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
        duration_s = self.n_rows / self.rate_hz
        middle = round(hz * duration_s)
        n_band = next_fast_len(2 * max(8, round(SEEN_AROUND * reach_hz * duration_s)))
        places = middle - n_band // 2 + np.arange(n_band)
        inside = (places > 0) & (places < len(self.level))
        band = np.zeros((n_band, self.level.shape[1]), dtype=complex)
        band[inside] = self.level[places[inside]]
        rows = ifft(np.fft.ifftshift(band, axes=0), axis=0) * (n_band / self.n_rows)
        turn = 2.0 * np.pi * (hz * duration_s - middle) * np.arange(n_band) / n_band
        slow, time = baseband(rows, turn, n_band / duration_s, reach_hz)
        _, vectors = np.linalg.eigh(slow.T @ slow.conj())
        return np.asarray(slow @ vectors[:, -1].conj()), time
