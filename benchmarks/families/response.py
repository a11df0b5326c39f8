"""Responses of modes to forces, exact for forces below half the sample rate.

No step of integration is held or bent: forces repeat after a period longer than record and decay,
each mode answers with its own frequency response, and a record is cut out of the period.  Where
frequencies drift, all by one factor r(t), the modes live in their own time τ, dτ = r dt, in which
they do not drift: z' = s r(t) z + b u is dz/dτ = s z + b u / r.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.fft import fft, fftfreq, ifft, next_fast_len
from scipy.interpolate import make_interp_spline

from benchmarks.families.force import Envelope, Spectrum
from benchmarks.identifier.plant import Plant

DECAYS = 6.0
"""Time constants of the slowest mode by which the period is longer than the record."""
MOST_EXTRA = 600_000
FINER = 4
"""Finer grid from which a drifting response is read off by a spline."""
AROUND = 3.0
"""Half-widths to either side of a mode in which its response counts as its own."""
MARGIN = 8
"""Samples before the record that the spline sees."""


def modal_accelerations(
    plant: Plant,
    force: NDArray[np.float64],
    rate_hz: float,
    edge: float,
) -> Iterator[NDArray[np.complex128]]:
    """Yield the spectrum of each mode's a(t); the acceleration is the sum of 2 Re(ψ a).

    Parameters
    ----------
    plant : Plant
        Complex form, see :class:`benchmarks.families.structure.Modal`.
    force : (n_samples, n_forces) array
        One period.
    rate_hz : float [Hz]
        Of the samples.
    edge : float
        End of the band before the converter as a share of the rate; 0.5: no filter.
    """
    hz = fftfreq(len(force), 1.0 / rate_hz)
    spectra = fft(force, axis=0)
    passed = anti_alias(hz / rate_hz, edge)
    for pole, participation in zip(poles(plant), plant.participation, strict=True):
        s = 2j * np.pi * hz
        yield passed * s**2 / (s - pole) * (spectra @ participation)


def poles(plant: Plant) -> NDArray[np.complex128]:
    """Return the poles in the upper half plane [rad/s]."""
    zeta = plant.damping_ratio
    return np.asarray(2.0 * np.pi * plant.frequency_hz * (-zeta + 1j * np.sqrt(1.0 - zeta**2)))


def anti_alias(share: NDArray[np.float64], edge: float) -> NDArray[np.float64]:
    """Return the gain of the filter before the converter, a cosine from its edge to 0.5."""
    if edge >= 0.5:
        return np.ones_like(share)
    beyond = np.clip((np.abs(share) - edge) / (0.5 - edge), 0.0, 1.0)
    return np.asarray(0.5 * (1.0 + np.cos(np.pi * beyond)))


def period(plant: Plant, n_samples: int, rate_hz: float) -> int:
    """Return the samples after which forces may repeat."""
    slowest = float(np.min(-poles(plant).real))
    extra = min(MOST_EXTRA, int(DECAYS / slowest * rate_hz))
    return int(next_fast_len(n_samples + extra + 16))


def draw_force(
    rng: np.random.Generator,
    n_forces: int,
    n_period: int,
    rate_hz: float,
    spectrum: Spectrum,
    envelope: Envelope,
) -> NDArray[np.float64]:
    """Draw one period of Gaussian forces; the record is its end."""
    force = rng.standard_normal((n_period, n_forces))
    gain = spectrum(np.abs(fftfreq(n_period, 1.0 / rate_hz)))
    if np.any(gain != 1.0):
        force = ifft(fft(force, axis=0) * gain[:, None], axis=0).real
    strength = np.full(n_period, envelope[0])
    strength[-len(envelope) :] = envelope
    return np.asarray(force * strength[:, None])


def in_time(
    spectrum: NDArray[np.complex128], n_samples: int, own_time: NDArray[np.float64] | None = None
) -> NDArray[np.complex128]:
    """Return a mode's a(t) over the record, (n_samples,).

    Parameters
    ----------
    spectrum : (n_period,) array
        From :func:`modal_accelerations`.
    n_samples : int
        Of the record, the end of the period.
    own_time : (n_samples,) array or None
        Where frequencies drift: the modes' time in samples since the start of the record.
    """
    n_period = len(spectrum)
    if own_time is None:
        return np.asarray(ifft(spectrum)[n_period - n_samples :])
    fine = np.zeros(FINER * n_period, dtype=complex)
    half = n_period // 2
    fine[:half], fine[-half:] = spectrum[:half], spectrum[-half:]
    first = n_period - n_samples - MARGIN
    values = FINER * ifft(fine)[FINER * first :]
    place = np.arange(len(values)) / FINER - MARGIN
    return np.asarray(make_interp_spline(place, values, k=7)(own_time))


def power_around(
    modal: NDArray[np.complex128], plant: Plant, mode: int, rate_hz: float, n_samples: int
) -> float:
    """Return the mean power of a(t) over the record, within three half-widths of its mode."""
    n_period = len(modal)
    centre = plant.frequency_hz[mode] * n_period / rate_hz
    reach = max(n_period / n_samples, AROUND * plant.damping_ratio[mode] * centre)
    first, last = max(1, int(centre - reach)), min(n_period // 2, int(np.ceil(centre + reach)) + 1)
    around = np.zeros_like(modal)
    around[first:last] = modal[first:last]
    return float(np.mean(np.abs(in_time(around, n_samples)) ** 2))
