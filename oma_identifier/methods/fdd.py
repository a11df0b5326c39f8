"""Frequency domain decomposition: peaks of singular values, and their damping without leakage.

The enhanced method takes the damping from the decay of a band-passed correlation of a smoothed
spectrum, which adds the width of the spectral window to that of the mode.  Here the bell of each
mode is fitted in the raw periodogram of its modal coordinate, which has no window.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.fft import rfft

from modal_core.mode import Mode, ModeSet
from modal_core.numbers.indicators import mac, mpc, mpd, normalise
from modal_core.numbers.prominence import prominent_peaks
from modal_core.numbers.tapers import hann
from modal_core.samples import Samples
from oma_identifier.likelihood import averages_from, BandModel, fit_band
from oma_identifier.methods.thresholds import METHOD
from oma_identifier.refinement import refine, REFINEMENT

WHOLE = (0.0, np.inf)


@dataclass(frozen=True, slots=True)
class Decomposition:
    """Singular values and first singular vectors of the cross spectral density.

    Parameters
    ----------
    frequency_hz : (n_frequencies,) array [Hz]
        Lines.
    singular_value : (n_frequencies, n_values) array
        Falling, of channels scaled to unit mean square.
    vector : (n_frequencies, n_channels) complex array
        First singular vector in scaled channels.
    scale : (n_channels,) array [m/s²]
        Root mean square of the channels.
    n_averages : float
        Independent averages behind each value.
    """

    frequency_hz: NDArray[np.float64]
    singular_value: NDArray[np.float64]
    vector: NDArray[np.complex128]
    scale: NDArray[np.float64]
    n_averages: float


def decompose(samples: Samples, resolution_hz: float | None = None) -> Decomposition:
    """Return the singular value decomposition at every frequency.

    Parameters
    ----------
    samples : Samples
        Responses.
    resolution_hz : float [Hz] or None
        Distance of lines; None: of four dozen segments, of a short record fewer.

    References
    ----------
    Brincker, Zhang and Andersen (2001), doi:10.1088/0964-1726/10/3/303.
    """
    rows = samples.widened()
    rows = rows - rows.mean(axis=0)
    scale = rows.std(axis=0)
    inverse = np.divide(1.0, scale, out=np.zeros_like(scale), where=scale > 0.0)
    covariance = (rows.T @ rows) * np.outer(inverse, inverse)
    basis = np.linalg.eigh(covariance)[1][:, ::-1][:, : METHOD.most_coordinates]
    rate = samples.sample_rate_hz
    length = _segment(len(rows), rate)
    if resolution_hz is not None:
        length = min(len(rows), max(32, round(rate / resolution_hz)))
    reduced = rows @ (basis * inverse[:, None])
    starts = range(0, len(rows) - length + 1, max(1, length // 2))
    taper = hann(length)[:, None]
    density = np.zeros((length // 2 + 1, basis.shape[1], basis.shape[1]), dtype=complex)
    for start in starts:
        lines = rfft(reduced[start : start + length] * taper, axis=0)
        density += lines[:, :, None] * lines[:, None, :].conj()
    values, vectors = np.linalg.eigh(density / len(starts))
    return Decomposition(
        np.arange(len(density)) * rate / length,
        values[:, ::-1],
        np.asarray(vectors[:, :, -1] @ basis.T),
        scale,
        # Half-overlapping Hann segments: a little more than those that do not overlap.
        max(1.0, 0.55 * len(starts)),
    )


def _segment(n_rows: int, rate_hz: float) -> int:
    """Return the rows of one of many segments, of short records of fewer."""
    most, fewest = (2 * n_rows // (n + 1) for n in (METHOD.fewest_segments, METHOD.segments))
    return max(32, fewest, min(most, round(METHOD.segment_s * rate_hz)))


def fdd(
    samples: Samples,
    resolution_hz: float | None = None,
    band_hz: tuple[float, float] = WHOLE,
) -> ModeSet:
    """Return the modes at the significant peaks of the first singular value, without damping.

    A line of the spectrum is no estimate with a known scatter: all deviations are NaN.

    Parameters
    ----------
    samples : Samples
        Responses.
    resolution_hz : float [Hz] or None
        Distance of lines; None: of four dozen segments, of a short record fewer.
    band_hz : (2,) tuple [Hz]
        Peaks outside are left alone.

    Raises no error when there is no peak: the set is empty.
    """
    spectrum = decompose(samples, resolution_hz)
    modes = []
    for peak in _inside(spectrum, band_hz):
        shape = normalise(spectrum.vector[peak] * spectrum.scale)
        modes.append(_mode(_parabola(spectrum, peak), np.nan, shape))
    return ModeSet(tuple(modes), samples.channel_names, 'fdd')


def peaks(spectrum: Decomposition) -> NDArray[np.int64]:
    """Return the lines where ln σ₁ peaks by several times its own scatter."""
    first = np.log(np.maximum(spectrum.singular_value[:, 0], np.finfo(float).tiny))
    prominence = METHOD.significant / np.sqrt(spectrum.n_averages)
    found = prominent_peaks(first, prominence).place
    # A peak of noise has another shape at the next line.
    alike = [
        line
        for line in found
        if mac(spectrum.vector[line], spectrum.vector[line - 1])[0, 0] > METHOD.bell_mac
        and mac(spectrum.vector[line], spectrum.vector[line + 1])[0, 0] > METHOD.bell_mac
    ]
    return np.array(alike, dtype=np.int64)


def _inside(spectrum: Decomposition, band_hz: tuple[float, float]) -> NDArray[np.int64]:
    found = peaks(spectrum)
    place_hz = spectrum.frequency_hz[found]
    return found[(place_hz >= band_hz[0]) & (place_hz <= band_hz[1])]


def efdd(
    samples: Samples,
    resolution_hz: float | None = None,
    band_hz: tuple[float, float] = WHOLE,
) -> ModeSet:
    """Return the modes at the peaks with frequency and damping fitted over their bells.

    A peak whose bell cannot be fitted is left out.  Deviations are those of the likelihood.

    Parameters
    ----------
    samples : Samples
        Responses.
    resolution_hz : float [Hz] or None
        Distance of lines; None: of four dozen segments, of a short record fewer.
    band_hz : (2,) tuple [Hz]
        Peaks outside are left alone.

    References
    ----------
    Jacobsen, Andersen and Brincker (2006), IMAC XXIV, Using enhanced frequency domain
    decomposition as a robust technique to harmonic excitation (bells).
    """
    spectrum = decompose(samples, resolution_hz)
    lines = _inside(spectrum, band_hz)
    if len(lines) == 0:
        return ModeSet((), samples.channel_names, 'efdd')
    rows = samples.widened()
    rows = (rows - rows.mean(axis=0)) / np.where(spectrum.scale > 0.0, spectrum.scale, np.inf)
    shapes = spectrum.vector[lines].T
    filters = _modal_filters(shapes)
    coordinates = rfft(rows @ filters.real.T, axis=0) + 1j * rfft(rows @ filters.imag.T, axis=0)
    coordinates /= np.sqrt(len(rows))
    frequency = np.arange(len(coordinates)) * samples.sample_rate_hz / len(rows)
    modes = []
    for index, line in enumerate(lines):
        low, high = _bell(spectrum, int(line))
        inside = (frequency > low) & (frequency < high)
        start_hz = _parabola(spectrum, int(line))
        found = _fit(frequency[inside], coordinates[inside, index], start_hz)
        if found is not None:
            shape = normalise(shapes[:, index] * spectrum.scale)
            modes.append(_mode(found[0], found[1], shape, found[2], found[3]))
    modes.sort(key=lambda mode: mode.frequency_hz)
    # Bells that overlap are fitted once more, together; of two close modes often only one peaks.
    refined = refine(samples, ModeSet(tuple(modes), samples.channel_names, 'efdd'))
    joined = [
        *refined.modes,
        *(
            mode
            for mode, misfit in zip(refined.added, refined.added_misfit, strict=True)
            if misfit < REFINEMENT.adopted_misfit and band_hz[0] <= mode.frequency_hz <= band_hz[1]
        ),
    ]
    joined.sort(key=lambda mode: mode.frequency_hz)
    return ModeSet(tuple(joined), samples.channel_names, 'efdd')


def _modal_filters(shapes: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Return rows that pick one shape each and, with channels enough, none of the others."""
    n_channels, n_modes = shapes.shape
    unit = shapes / np.linalg.norm(shapes, axis=0)
    if n_modes < n_channels and np.linalg.cond(unit) < 10.0:
        return np.asarray(np.linalg.pinv(unit))
    return np.asarray(unit.conj().T)


def _bell(spectrum: Decomposition, line: int) -> tuple[float, float]:
    """Return the frequencies between which the first singular vector is that of the peak."""
    alike = mac(spectrum.vector[line], spectrum.vector.T)[0] > METHOD.bell_mac
    left = right = line
    while left > 1 and alike[left - 1]:
        left -= 1
    while right < len(alike) - 2 and alike[right + 1]:
        right += 1
    return float(spectrum.frequency_hz[left]), float(spectrum.frequency_hz[right])


def _parabola(spectrum: Decomposition, line: int) -> float:
    """Return the peak of the parabola through ln σ₁ at three lines [Hz]."""
    values = np.log(spectrum.singular_value[line - 1 : line + 2, 0])
    curvature = values[0] - 2.0 * values[1] + values[2]
    offset = 0.5 * (values[0] - values[2]) / curvature if curvature < 0.0 else 0.0
    return float(spectrum.frequency_hz[line] + offset * spectrum.frequency_hz[1])


def _fit(
    frequency_hz: NDArray[np.float64], coordinate: NDArray[np.complex128], start_hz: float
) -> tuple[float, float, float, float] | None:
    """Fit one mode; the best of several starts of the damping, bells cut to what it needs."""
    damping = 0.02
    result = None
    for _ in range(3):  # the width of the bell follows the damping
        reach = max(
            METHOD.bell_half_widths * damping * start_hz, 6.0 * (frequency_hz[1] - frequency_hz[0])
        )
        near = np.abs(frequency_hz - start_hz) < reach
        if np.count_nonzero(near) < 12:
            return None
        data = averages_from(
            frequency_hz[near],
            coordinate[near, None],
            np.array([start_hz]),
            np.array([damping * start_hz]),
        )
        power = float(np.mean(np.abs(coordinate[near]) ** 2))
        model = BandModel(
            np.array([start_hz]),
            np.array([damping]),
            np.ones((1, 1), dtype=complex),
            np.array([[power * damping]], dtype=complex),
            np.array([1e-3 * power]),
            1,
            reference_hz=start_hz,
        )
        fit = fit_band(data, model)
        if not fit.converged:
            return None
        start_hz, damping = float(fit.model.frequency_hz[0]), float(fit.model.damping_ratio[0])
        result = (
            start_hz,
            damping,
            float(fit.frequency_std[0]) * start_hz,
            float(fit.damping_ratio_std[0]) * damping,
        )
    return result


def _mode(
    frequency_hz: float,
    damping_ratio: float,
    shape: NDArray[np.complex128],
    frequency_std_hz: float = np.nan,
    damping_ratio_std: float = np.nan,
) -> Mode:
    return Mode(
        frequency_hz,
        damping_ratio,
        shape,
        frequency_std_hz,
        damping_ratio_std,
        mpc=float(mpc(shape[:, None])[0]),
        mpd=float(mpd(shape[:, None])[0]),
    )
