"""What each channel measured over frequency, and what the modes make of it."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
import scipy.signal

from modal_core.mode import Mode
from modal_core.samples import Samples
from modal_reports import ChannelSpectra

Array = NDArray[np.float64]
MOST_CHANNELS = 64
"""Shown in a report: 64 times 500 lines are half a megabyte."""
MOST_LINES, FEWEST_SEGMENTS, MOST_SEGMENTS = 500, 16, 200
"""Lines of a spectrum, and segments it is the mean of: of 16 the coherence of noise is 1/16, and
spectra of 200, evenly taken of a long recording, scatter by 7 %."""
FINE = 8
"""Points per line of the spectrum that a bell is computed at before the window smears it."""


def channel_spectra(
    samples: Samples, modes: Sequence[Mode], band_hz: tuple[float, float]
) -> ChannelSpectra | None:
    """Return measured and synthesised spectra of channels, and their coherence with one of them.

    Parameters
    ----------
    samples : Samples
        One stretch of what was identified.
    modes : sequence of Mode
        Of the structure.
    band_hz : (float, float) [Hz]
        That is shown.

    Returns
    -------
    ChannelSpectra or None
        None of a stretch that is too short.
    """
    rate_hz, n = samples.sample_rate_hz, len(samples.acceleration)
    high_hz = min(band_hz[1], rate_hz / 2.0)
    length = min(2 * n // (FEWEST_SEGMENTS + 1), int(MOST_LINES * rate_hz / high_hz))
    if length < 32:
        return None
    names = samples.channel_names[:MOST_CHANNELS]
    spectra, at_hz = _cross_spectra(samples, length)
    shown = (at_hz >= max(band_hz[0], at_hz[2])) & (at_hz <= high_hz)
    psd = np.einsum('kii->ki', spectra).real[shown]
    ends = np.maximum(psd, 1e-12 * psd.max(initial=1e-300))
    squared = np.abs(spectra[shown]) ** 2 / (ends[:, :, None] * ends[:, None, :])
    reference = int(np.argmax(squared.mean(axis=(0, 1))))
    bells = _bells(modes, at_hz[shown], at_hz[1])
    return ChannelSpectra(
        names=names,
        reference=names[reference],
        frequency_hz=at_hz[shown],
        psd=psd,
        synthesised=np.column_stack([_fitted(bells, column) for column in ends.T]),
        coherence=np.clip(squared[:, reference], 0.0, 1.0),
    )


def _cross_spectra(samples: Samples, length: int) -> tuple[NDArray[np.complex128], Array]:
    """Return one-sided cross-spectral densities by Welch's method, (n_lines, n, n)."""
    rate_hz, n = samples.sample_rate_hz, len(samples.acceleration)
    window = scipy.signal.get_window('hann', length)
    scale = 2.0 / (rate_hz * np.sum(window**2))
    n_channels = min(len(samples.channels), MOST_CHANNELS)
    found = np.zeros((length // 2 + 1, n_channels, n_channels), dtype=complex)
    starts = range(0, n - length + 1, max(length // 2, (n - length) // MOST_SEGMENTS))
    for start in starts:
        part = samples.widened(slice(start, start + length), slice(0, n_channels))
        lines = np.fft.rfft(window[:, None] * (part - part.mean(axis=0)), axis=0)
        found += lines[:, :, None] * lines[:, None, :].conj()
    at_hz = np.arange(length // 2 + 1) * (rate_hz / length)
    return found * (scale / len(starts)), np.asarray(at_hz, dtype=float)


def _bells(modes: Sequence[Mode], at_hz: Array, step_hz: float) -> Array:
    """Return what spectra of accelerations are made of, smeared by the window, (n_lines, n).

    In white excitation the auto-spectrum of a response is a sum of (a + b ω²) / |ω² + λ²|² over
    the modes, which real and imaginary part of 1/(iω - λ) + 1/(-iω - λ) span; beside them noise,
    and powers of ω that modes above the band leave.
    """
    offsets = np.arange(-2 * FINE, 2 * FINE + 1) / FINE
    fine = 2.0 * np.pi * (at_hz[:, None] + step_hz * offsets)
    columns = [np.ones_like(fine), fine**2, fine**4]
    for mode in modes:
        omega, zeta = 2.0 * np.pi * mode.frequency_hz, mode.damping_ratio
        pole = omega * (-zeta + 1j * np.sqrt(max(1.0 - zeta**2, 0.0)))
        both = 1.0 / (1j * fine - pole) + 1.0 / (-1j * fine - pole)
        columns += [both.real, both.imag]
    return np.column_stack([column @ _hann_power(offsets) for column in columns])


def _hann_power(offsets: Array) -> Array:
    """Return the power that a Hann window lets through off a line, in lines, with sum 1."""
    value = 0.5 * np.sinc(offsets) + 0.25 * (np.sinc(offsets - 1.0) + np.sinc(offsets + 1.0))
    return np.asarray(value**2 / np.sum(value**2))


def _fitted(bells: Array, measured: Array) -> Array:
    """Return the bells' best sum; spectra scatter by a share of themselves."""
    if not measured.any():
        return np.zeros(len(measured))
    found = np.full(len(measured), np.nan)
    expected = measured
    for _ in range(3):
        scaled = bells / expected[:, None]
        size = np.linalg.norm(scaled, axis=0)
        size[size == 0.0] = 1.0
        weights = np.linalg.lstsq(scaled / size, measured / expected, rcond=1e-10)[0]
        found = bells @ (weights / size)
        # Scatter of the true spectrum, not of the one that happened.
        expected = np.maximum(found, 0.05 * measured)
    return found
