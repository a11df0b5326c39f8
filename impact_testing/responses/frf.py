"""Frequency responses from several taps, with coherence and random error."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from impact_testing.responses.spectra import PointSpectra

Complex = NDArray[np.complex128]
Real = NDArray[np.float64]
BESIDE = 7
"""Lines on either side over which the noise is averaged."""


@dataclass(frozen=True)
class PointFrf:
    """Accelerances of all channels to forces at one point [m/s²/N].

    Parameters
    ----------
    spectra : PointSpectra
        Of the good taps.

    References
    ----------
    Bendat and Piersol (2010), Random Data, 4th ed., sections 6.2 and 9.2; Rocklin, Crowley and
    Vold (1985), A comparison of H1, H2 and Hv frequency response functions, IMAC III.
    """

    spectra: PointSpectra

    @cached_property
    def force_power(self) -> Real:
        """Σ |F|² over the taps, (n_lines,) array."""
        return np.asarray(np.sum(np.abs(self.spectra.force) ** 2, axis=0))

    @cached_property
    def h1(self) -> Complex:
        """S_xf / S_ff, (n_lines, n_channels): right where the responses have noise."""
        cross = np.einsum('kl,klc->lc', self.spectra.force.conj(), self.spectra.motion)
        return np.asarray(cross / self.force_power[:, None])

    @cached_property
    def motion_power(self) -> Real:
        """Σ |X|² over the taps, (n_lines, n_channels) array."""
        return np.asarray(np.sum(np.abs(self.spectra.motion) ** 2, axis=0))

    @property
    def h2(self) -> Complex:
        """S_xx / S_fx: right where the force has noise; infinite where nothing is in common."""
        with np.errstate(divide='ignore', invalid='ignore'):
            return np.asarray(self.h1 / self.coherence)

    @property
    def hv(self) -> Complex:
        """√(S_xx / S_ff) with the phase of S_xf: noise in both alike, by their levels."""
        size = np.sqrt(self.motion_power / self.force_power[:, None])
        return np.asarray(size * np.exp(1j * np.angle(self.h1)))

    @property
    def coherence(self) -> Real:
        """γ² = |S_xf|² / (S_ff S_xx), (n_lines, n_channels) array."""
        explained = np.abs(self.h1) ** 2 * self.force_power[:, None]
        return np.divide(
            explained, self.motion_power, out=np.zeros_like(explained), where=self.motion_power > 0
        )

    @property
    def random_error(self) -> Real:
        """σ of |H1| over |H1|, and of its phase [rad]: √((1 - γ²) / (2 n γ²))."""
        n_taps, coherence = self.spectra.n_taps, self.coherence
        with np.errstate(divide='ignore'):
            return np.asarray(np.sqrt((1.0 - coherence) / (2.0 * n_taps * coherence)))

    def noise(self, ends: Complex | None = None) -> tuple[Real, Real]:
        """Return the noise of the spectra: its course over the lines, and each channel's level.

        Power of channel c at line l is course[l] · level[c], from what the taps do not have in
        common; sensors of one kind have one course.

        Parameters
        ----------
        ends : (n_taps, n_lines, n_channels) complex array or None
            What the ends of segments explain.

        Returns
        -------
        course : (n_lines,) array
        level : (n_channels,) array
        """
        motion = self.spectra.motion if ends is None else self.spectra.motion - ends
        force = self.spectra.force
        common = np.einsum('kl,klc->lc', force.conj(), motion) / self.force_power[:, None]
        rest = motion - common * force[:, :, None]
        power = np.sum(np.abs(rest) ** 2, axis=0) / (len(force) - 1)
        level = np.maximum(np.median(power, axis=0), 1e-30)
        course = _smoothed(np.mean(power / level, axis=1))
        return course, np.asarray(np.mean(power / course[:, None], axis=0)) + 1e-30

    def unlikeness(self) -> Real:
        """Return how much each tap's answer differs from the others' over the usual, (n_taps,)."""
        force, motion = self.spectra.force, self.spectra.motion
        rest = motion - self.h1 * force[:, :, None]
        differs = np.sum(np.abs(rest) ** 2, axis=(1, 2)) / np.sum(np.abs(force) ** 2, axis=1)
        usual = float(np.median(differs))
        return np.sqrt(differs / usual) if usual > 0.0 else np.ones(len(force))


def _smoothed(power: Real) -> Real:
    """Return the mean over neighbouring lines, fewer at the ends."""
    kernel = np.ones(2 * BESIDE + 1)
    return np.asarray(
        np.convolve(power, kernel, 'same') / np.convolve(np.ones_like(power), kernel, 'same')
    )
