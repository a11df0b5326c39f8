"""What the fit sees of each point that was hit: FRFs, weights, and what ends of segments add."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from impact_testing.responses.frf import PointFrf

Complex = NDArray[np.complex128]
Real = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class PointData:
    """FRFs of one point in the band.

    Parameters
    ----------
    frf : PointFrf
        Of the whole range.
    lines : slice
        Of the band.
    course, level : (n_lines,), (n_channels,) array
        Power of the noise of an FRF is course · level.
    corrected_n : (n,) array [N]
        What the forces of all taps were changed by, in proportion to their sizes, by what the
        structure answered; empty: as they were read.
    absorbed : float
        Share of the noise of the responses that forces fitted to them take up.
    n_residual : int
        Terms that stand for what is out of the band.
    """

    frf: PointFrf
    lines: slice
    course: Real
    level: Real
    corrected_n: Real = field(default_factory=lambda: np.empty(0))
    absorbed: float = 0.0
    n_residual: int = 3

    @classmethod
    def of(cls, frf: PointFrf, lines: slice, ends: Complex | None = None) -> 'PointData':
        """Weigh the lines by the noise that the taps do not have in common."""
        course, level = frf.noise(ends)
        # Half of it is in the real, half in the imaginary part.
        power = 0.5 * course / frf.force_power * frf.spectra.correlation
        return cls(frf, lines, power[lines], level)

    @property
    def frequency_hz(self) -> Real:
        """Lines of the band [Hz]."""
        return self.frf.spectra.frequency_hz[self.lines]

    @property
    def target(self) -> Complex:
        """FRFs of the band with noise of one, (n_lines, n_channels) array."""
        scaled = self.frf.h1[self.lines] / np.sqrt(self.level)
        return np.asarray(scaled / np.sqrt(self.course[:, None]))

    @property
    def log_noise(self) -> float:
        """Logarithm of the power of the noise, summed over lines and channels."""
        return len(self.level) * float(np.log(self.course).sum()) + len(self.course) * float(
            np.log(self.level).sum()
        )

    def terms(self, pole: Complex) -> tuple[Complex, Complex]:
        """Return (1 + Σ_k F̄_k u_k / S_ff) / (jω - p) of p and of its conjugate.

        Returns
        -------
        two (n_lines, n_poles) arrays
        """
        spectra = self.frf.spectra
        force = spectra.force[:, self.lines].conj().T / self.frf.force_power[self.lines, None]
        windowed = pole - spectra.decay_1_s
        ends = spectra.ends(windowed)
        s = 2j * np.pi * self.frequency_hz[:, None]
        # The force is real, so that the ends of a conjugate are the conjugates of the ends.
        upper = (1.0 + force @ ends) / (s - windowed)
        lower = (1.0 + force @ ends.conj()) / (s - windowed.conj())
        return np.asarray(upper), np.asarray(lower)

    def reweighted(self, pole: Complex, amplitude: Complex) -> 'PointData':
        """Estimate the noise again, without what the ends of the segments explain.

        Parameters
        ----------
        pole : (n_poles,) complex array [rad/s]
        amplitude : (n_poles, n_channels) complex array
            In accelerances.
        """
        ends = self.frf.spectra.free_motion(pole, amplitude)
        fresh = PointData.of(self.frf, self.lines, ends)
        level = fresh.level / (1.0 - self.absorbed)
        return replace(self, course=fresh.course, level=level)


def band_lines(frequency_hz: Real, band_hz: tuple[float, float]) -> slice:
    """Return the lines of a band."""
    first, end = np.searchsorted(frequency_hz, band_hz)
    return slice(int(first), int(end))
