"""Singular values of the cross spectral density at every frequency, and where they peak."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.fft import rfft

from modal_core.numbers.indicators import mac
from modal_core.numbers.prominence import prominent_peaks
from modal_core.numbers.tapers import hann
from modal_core.samples import Samples
from oma_identifier.methods.thresholds import METHOD


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
        First singular vector in scaled channels, times anything.
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
    rows *= np.divide(1.0, scale, out=np.zeros_like(scale), where=scale > 0.0)
    rate = samples.sample_rate_hz
    length = _segment(len(rows), rate)
    if resolution_hz is not None:
        length = min(len(rows), max(32, round(rate / resolution_hz)))
    starts = range(0, len(rows) - length + 1, max(1, length // 2))
    taper = hann(length)[:, None]
    # What single precision rounds is far below what so few averages scatter.
    lines = np.empty((length // 2 + 1, len(starts), rows.shape[1]), dtype=np.complex64)
    for number, start in enumerate(starts):
        lines[:, number] = rfft(rows[start : start + length] * taper, axis=0)
    n_parts = max(1, len(lines) // METHOD.coordinate_lines)
    parts = [_singular(part) for part in np.array_split(lines, n_parts)]
    return Decomposition(
        np.arange(len(lines)) * rate / length,
        np.concatenate([values for values, _ in parts]),
        np.concatenate([vector for _, vector in parts]),
        scale,
        # Half-overlapping Hann segments: a little more than those that do not overlap.
        max(1.0, 0.55 * len(starts)),
    )


def _singular(
    lines: NDArray[np.complexfloating],
) -> tuple[NDArray[np.float64], NDArray[np.complex128]]:
    """Return the falling singular values of some lines, and the first singular vectors.

    The values are those of a few principal coordinates of these lines.  The vectors are of all
    channels: a shape need not lie in the coordinates.

    Parameters
    ----------
    lines : (n_lines, n_segments, n_channels) complex array
        Of the segments.
    """
    n_segments, n_channels = lines.shape[1:]
    flat = lines.reshape(-1, n_channels)
    basis = np.linalg.eigh((flat.conj().T @ flat).real)[1][:, ::-1][:, : METHOD.most_coordinates]
    reduced = (flat @ basis).reshape(len(lines), n_segments, -1)
    values, vectors = np.linalg.eigh(reduced.transpose(0, 2, 1) @ reduced.conj() / n_segments)
    first = reduced.conj() @ vectors[:, :, -1:]
    return values[:, ::-1], np.asarray((lines.transpose(0, 2, 1) @ first)[:, :, 0])


def _segment(n_rows: int, rate_hz: float) -> int:
    """Return the rows of one of many segments, of short records of fewer."""
    most, fewest = (2 * n_rows // (n + 1) for n in (METHOD.fewest_segments, METHOD.segments))
    return max(32, fewest, min(most, round(METHOD.segment_s * rate_hz)))


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


def bell(spectrum: Decomposition, line: int) -> tuple[float, float]:
    """Return the frequencies between which the first singular vector is that of the peak."""
    alike = mac(spectrum.vector[line], spectrum.vector.T)[0] > METHOD.bell_mac
    left = right = line
    while left > 1 and alike[left - 1]:
        left -= 1
    while right < len(alike) - 2 and alike[right + 1]:
        right += 1
    return float(spectrum.frequency_hz[left]), float(spectrum.frequency_hz[right])
