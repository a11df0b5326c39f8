"""How differently the taps on a point moved each mode: hammers do not hit one spot twice.

A tap a little beside the point, or askew, moves each mode by another factor.  The noise of the
lines does not tell it: it is one number for all of them, and for all channels.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr
from scipy.stats import t as student

from impact_testing.responses.band_data import PointData
from impact_testing.responses.basis import apart

Complex = NDArray[np.complex128]
Real = NDArray[np.float64]


def tap_scatter(data: PointData, pole: Complex, amplitude: Complex) -> tuple[Real, Real]:
    """Return by how much a mode's size differs from tap to tap, as a share, and what noise does.

    Parameters
    ----------
    data : PointData
        Of one point.
    pole : (n_modes,) complex array [rad/s]
    amplitude : (n_modes, n_channels) complex array
        Of accelerances.

    Returns
    -------
    two (n_modes,) arrays
        Standard deviations of single taps: what is seen, and what the noise of responses and force
        has of it.
    """
    # As it was read: the most likely force has taken up what the hammer hit otherwise.
    spectra, lines = data.frf.spectra.as_read(), data.lines
    windowed = pole - spectra.decay_1_s
    s = 2j * np.pi * data.frequency_hz[:, None]
    own = np.einsum('lp,pc->lcp', 1.0 / (s - windowed), amplitude)
    own = own + np.einsum('lp,pc->lcp', 1.0 / (s - windowed.conj()), amplitude.conj())
    force = spectra.force[:, lines]
    motion = spectra.motion[:, lines] - spectra.free_motion(pole, amplitude, lines)
    power = np.sum(np.abs(force) ** 2, axis=0)
    common = np.einsum('kl,klc->lc', force.conj(), motion) / power[:, None]
    rest = motion - force[:, :, None] * common
    # Where modes are small there is but noise: the median line is one of them.
    n_free = spectra.n_taps - 1
    level = np.median(np.sum(np.abs(rest) ** 2, axis=0), axis=0) / n_free + 1e-300
    weight = 1.0 / np.sqrt(level)
    near = np.abs(data.frequency_hz[:, None] - np.abs(pole) / (2.0 * np.pi)).argmin(axis=0)
    longest = max(len(pulse.force_n) for pulse in spectra.pulses)
    force_noise = longest * (spectra.force_noise_n / spectra.record.rate_hz) ** 2
    seen, by_noise = np.zeros(len(pole)), np.zeros(len(pole))
    for tap, left in zip(force, rest, strict=True):
        columns = apart((tap[:, None, None] * own * weight[:, None]).reshape(-1, len(pole)))
        inverse = np.linalg.pinv(columns.T @ columns, hermitian=True)
        share = inverse @ (columns.T @ apart((left * weight).ravel()))
        size = np.sum(np.abs(tap) ** 2) / power.sum()
        seen += size * share**2
        by_noise += 0.5 * size * (np.diag(inverse) + force_noise / np.abs(tap[near]) ** 2)
    n_alike = _alike(data)
    return np.sqrt(seen * n_alike / (n_alike - 1.0)), np.sqrt(by_noise)


def of_the_mean(data: PointData, scatter: Real) -> Real:
    """Return the deviation of the mean of the taps, whose two hold what two of a normal one do."""
    n_alike = _alike(data)
    few = float(student.ppf(ndtr(2.0), n_alike - 1.0)) / 2.0
    return np.asarray(few * scatter / np.sqrt(n_alike))


def _alike(data: PointData) -> float:
    """Return as how many taps of one size they count: strong ones tell more."""
    size = np.sum(np.abs(data.frf.spectra.force[:, data.lines]) ** 2, axis=1)
    return float(np.sum(size) ** 2 / np.sum(size**2))
